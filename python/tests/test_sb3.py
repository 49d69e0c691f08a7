"""The environments of Stable-Baselines3, where it is installed."""

import numpy as np
import pytest

pytest.importorskip("stable_baselines3")
from stable_baselines3 import PPO

from naoisis.sb3 import VecEnv


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
