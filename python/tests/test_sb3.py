"""The environments of Stable-Baselines3, where it is installed."""

import numpy as np
import pytest

pytest.importorskip("stable_baselines3")
from stable_baselines3 import PPO

import naoisis
from naoisis.sb3 import VecEnv, actor


@pytest.mark.parametrize("action", ["continuous", "multi_discrete", "discrete", "velocities"])
def test_a_policy_learns_for_some_steps(action):
    envs = VecEnv("TwoOnTwo", 2, control="blue", action=action, set={"duration_s": 1})
    model = PPO("MlpPolicy", envs, n_steps=16, batch_size=16, n_epochs=1, seed=1, device="cpu").learn(128)
    actions, _ = model.predict(envs.reset())
    assert len(actions) == envs.num_envs == 4


def test_the_end_of_an_episode_is_told_apart():
    envs = VecEnv("ScoreEmptyGoal", 3, observation="truth", set={"duration_s": 1})
    envs.seed(5)
    envs.reset()
    stand = np.zeros((3, 8), np.float32)
    for step in range(10):
        observations, rewards, dones, infos = envs.step(stand)
        assert dones.all() == (step == 9)
    assert all(info["TimeLimit.truncated"] and not info["is_success"] for info in infos)
    assert infos[1]["terminal_observation"].shape == observations[1].shape
    assert not np.array_equal(infos[1]["terminal_observation"], observations[1])


def test_options_are_those_of_the_next_episodes():
    envs = VecEnv("ScoreEmptyGoal", 3, observation="truth")
    x = envs.envs.state_names.index("ball.x")

    def at(x_m):
        return {"situation": {"ball": {"x_m": [x_m, x_m], "y_m": [0, 0]}}, "set": {"duration_s": 0.2}}

    envs.set_options(at(1.0))
    envs.reset()
    for _ in range(5):
        assert (envs.envs.state()[:, x] == 1.0).all()
        envs.step(np.zeros((3, 8), np.float32))
    envs.set_options([at(1.0), at(2.0), at(1.0)])
    observations = envs.reset()
    assert list(envs.envs.state()[:, x]) == [1.0, 2.0, 1.0] and observations.shape[0] == 3
    # They are gone with the reset, as in the other environments of this library.
    envs.reset()
    assert (envs.envs.state()[:, x] != 1.0).all()
    envs.set_options({"foo": 1})
    with pytest.raises(ValueError, match="there is no 'foo'"):
        envs.reset()


def test_environments_of_pettingzoo_come_through_supersuit():
    supersuit = pytest.importorskip("supersuit")
    envs = supersuit.pettingzoo_env_to_vec_env_v1(naoisis.parallel_env("TwoOnTwo"))
    envs = supersuit.concat_vec_envs_v1(envs, 2, num_cpus=0, base_class="stable_baselines3")
    PPO("MlpPolicy", envs, n_steps=16, batch_size=16, n_epochs=1, device="cpu").learn(64)


@pytest.mark.parametrize("action", ["continuous", "multi_discrete", "discrete"])
def test_what_was_learned_is_a_policy_of_matches(tmp_path, action):
    pytest.importorskip("onnx")
    envs = VecEnv("TwoOnTwo", 1, control="blue", observation="belief", action=action, set={"duration_s": 1})
    model = PPO("MlpPolicy", envs, n_steps=16, batch_size=16, n_epochs=1, seed=1, device="cpu").learn(64)
    policy = naoisis.export_policy(actor(model), tmp_path / "policy.onnx", model.env)
    observations = envs.reset()
    expected, _ = model.predict(observations, deterministic=True)
    assert np.allclose(policy(observations), expected, atol=1e-4)
