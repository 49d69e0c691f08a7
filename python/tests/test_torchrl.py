"""Many worlds as one environment of TorchRL, and tasks of BenchMARL."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest

import naoisis

torch = pytest.importorskip("torch")
pytest.importorskip("torchrl")
from tensordict.nn import TensorDictModule
from torchrl.envs import RewardSum, SerialEnv, TransformedEnv, check_env_specs
from torchrl.envs.utils import MarlGroupMapType

from naoisis.torchrl import MatchEnv

SHORT = {"duration_s": 1}


@pytest.mark.parametrize("action", ["continuous", "multi_discrete", "discrete", "velocities"])
@pytest.mark.parametrize("observation", ["perception", "belief", "truth", "image"])
def test_torchrl_accepts_it(observation, action):
    check_env_specs(MatchEnv("TwoOnTwo", 2, observation=observation, action=action, set=SHORT))


def test_groups_are_teams_of_agents():
    env = MatchEnv("match3v3", 2, control=["blue1", "pink1", "pink3"], observation="image", set=SHORT)
    assert env.group_map == {"blue": ["blue_1"], "pink": ["pink_1", "pink_3"]}
    check_env_specs(env)
    data = env.rollout(3)
    assert data.batch_size == (2, 3) and data["state"].shape == (2, 3, len(env.state_names))
    assert data["pink", "pixels"].shape == (2, 3, 2, 48, 64, 3) and data["pink", "pixels"].dtype == torch.uint8
    assert data["pink", "observation"].shape == (2, 3, 2, len(env.observation_names))
    assert data["next", "blue", "reward"].shape == (2, 3, 1, 1) and data["pink", "action"].shape == (2, 3, 2, 8)
    assert env.render().shape == (270, 480, 3) and len(env.truth(1)["robots"]) == 6
    with pytest.raises(KeyError):
        data["blue", "pixels_of_others"]


@pytest.mark.parametrize(
    ("groups", "expected"),
    [
        (MarlGroupMapType.ALL_IN_ONE_GROUP, {"agents": ["blue_1", "pink_1"]}),
        (MarlGroupMapType.ONE_GROUP_PER_AGENT, {"blue_1": ["blue_1"], "pink_1": ["pink_1"]}),
        ({"a": ["pink_1"], "b": ["blue_1"]}, {"a": ["pink_1"], "b": ["blue_1"]}),
    ],
)
def test_groups_can_be_others(groups, expected):
    env = MatchEnv("match3v3", 2, control=["blue1", "pink1"], observation="truth", group_map=groups, set=SHORT)
    check_env_specs(env)
    assert env.group_map == expected
    env.set_seed(1)
    first = env.reset()
    plain = naoisis.vector_env("match3v3", 2, control=["blue1", "pink1"], observation="truth", set=SHORT)
    rows, _ = plain.reset(seed=1)
    for group, agents in expected.items():
        for member, agent in enumerate(agents):
            seen = first[group, "observation"][:, member].numpy()
            assert np.array_equal(seen, rows[0 if agent == "blue_1" else 1 :: 2])


@pytest.mark.parametrize("action", ["continuous", "multi_discrete", "discrete"])
def test_it_is_the_same_as_the_environment_of_gymnasium(action):
    options = {"control": ["blue", "pink"], "observation": "belief", "action": action, "set": SHORT}
    env = MatchEnv("match3v3", 3, seed=7, **options)
    data = env.rollout(25, break_when_any_done=False)
    plain = naoisis.vector_env("match3v3", 3, autoreset_mode="disabled", **options)
    seen, _ = plain.reset(seed=7)
    for step in range(25):
        both = data[:, step]
        assert np.array_equal(seen.reshape(3, 6, -1)[:, :3], both["blue", "observation"].numpy())
        assert np.array_equal(plain.state(), both["state"].numpy())
        actions = torch.cat([both["blue", "action"], both["pink", "action"]], 1).numpy()
        seen, rewards, terminations, truncations, info = plain.step(actions.reshape(18, *actions.shape[2:]))
        after = both["next"]
        assert np.array_equal(rewards.reshape(3, 6)[:, 3:], after["pink", "reward"][..., 0].numpy())
        # The last observation of an episode is there, before the first one of the next.
        assert np.array_equal(seen.reshape(3, 6, -1)[:, 3:], after["pink", "observation"].numpy())
        assert np.array_equal(plain.state(), after["state"].numpy())
        assert np.array_equal(truncations.reshape(3, 6)[:, :1], after["truncated"].numpy())
        over = terminations | truncations
        assert np.array_equal(over.reshape(3, 6)[:, :1], after["done"].numpy())
        if over.any():
            success = info["success"].reshape(3, 6)[:, :3]
            assert np.array_equal(success, after["blue", "info", "success"][..., 0].numpy())
            seen, _ = plain.reset(options={"reset_mask": over})
    assert data["next", "done"].sum() == 2 * 3


def test_worlds_rest_while_others_play_to_their_end():
    env = MatchEnv("KeepGoal", 8, seed=3)
    stand = TensorDictModule(lambda state: torch.zeros(8, 1, 8), in_keys=["state"], out_keys=[("blue", "action")])
    data = env.rollout(200, stand, break_when_any_done=False, break_when_all_done=True)
    ends = [int(done.nonzero()[0]) for done in data["next", "done"][..., 0]]
    assert data["next", "done"][:, -1].all() and len(set(ends)) > 1
    for world, end in enumerate(ends):
        for name in (("blue", "observation"), "state", "done"):
            values = data["next"][name][world]
            assert (values[end:] == values[end]).all() and not (values[:end] == values[end]).all()
    # Afterwards everybody plays again.
    assert not env.reset()["done"].any()
    assert env.rollout(3).batch_size == (8, 3)


def test_a_world_that_rests_has_no_reward_and_stays_as_it_was():
    env = MatchEnv("KeepGoal", 4, seed=3)
    data = env.reset().set(("blue", "action"), torch.zeros(4, 1, 8))
    for _ in range(200):
        data = env.step(data)["next"].set(("blue", "action"), torch.zeros(4, 1, 8))
        if data["done"].any():
            break
    plays = ~data["done"]
    assert plays.any() and not plays.all()
    before = data.clone()
    for _ in range(3):
        data["_step"] = plays
        data = env.step(data)["next"].set(("blue", "action"), torch.zeros(4, 1, 8))
        plays &= ~data["done"]
    rests = before["done"].squeeze(-1)
    assert (data["blue", "reward"][rests] == 0).all() and data["done"][rests].all()
    assert (data["state"][rests] == before["state"][rests]).all()
    assert (data["state"][~rests] != before["state"][~rests]).any()


def test_who_has_not_ended_cannot_rest():
    env = MatchEnv("FindBall", 2, seed=3)
    data = env.rand_action(env.reset())
    data["_step"] = torch.tensor([True, False])
    with pytest.raises(ValueError, match="_step: the episode of world 1 is not over"):
        env.step(data)
    with pytest.raises(ValueError, match="options: there is no 'sets'"):
        env.reset(options={"sets": {}})


def test_seeds_repeat_episodes_and_each_is_another():
    def starts(env):
        data = env.rollout(30, break_when_any_done=False)
        begun = torch.cat([torch.ones(2, 1, dtype=bool), data["next", "done"][:, :-1, 0]], 1)
        return data["state"][begun]

    env = MatchEnv("ScoreEmptyGoal", 2, set=SHORT, seed=5)
    first = starts(env)
    assert len(first) == 6 == len(torch.unique(first, dim=0))
    env.set_seed(5)
    # A seed is that of the next reset of all worlds, and not of each that follows.
    assert torch.equal(starts(env), first)
    env.set_seed(6)
    assert not torch.equal(starts(env), first)
    drawn = []
    for _ in range(2):
        torch.manual_seed(1)
        drawn.append(starts(MatchEnv("ScoreEmptyGoal", 2, set=SHORT)))
    assert torch.equal(*drawn)


def test_options_of_a_reset_are_those_of_gymnasium():
    env = MatchEnv("ScoreEmptyGoal", 2, observation="truth", seed=1)
    place = {"ball": {"x_m": [1.0, 1.0], "y_m": [0.5, 0.5]}}
    first = env.reset(options={"situation": place})
    names = env.state_names
    assert first["state"][:, names.index("ball.x")] == pytest.approx([1.0, 1.0])


def test_transforms_and_several_of_them_work():
    def made():
        return MatchEnv("TwoOnTwo", 2, action="discrete", set=SHORT)

    env = TransformedEnv(
        made(), RewardSum(in_keys=[("blue", "reward")], out_keys=[("blue", "episode_reward")], reset_keys=["_reset"])
    )
    check_env_specs(env)
    data = env.rollout(5)
    assert torch.allclose(data["next", "blue", "reward"].sum(1), data["next", "blue", "episode_reward"][:, -1])
    several = SerialEnv(2, made)
    assert several.rollout(3).batch_size == (2, 2, 3)


def test_the_example_trains():
    path = Path(__file__).parent.parent / "examples/torchrl/team.py"
    spec = importlib.util.spec_from_file_location("team", path)
    team = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(team)
    rewards = team.main(frames=512, worlds=4)
    assert len(rewards) == 1 and np.isfinite(rewards).all()


def test_benchmarl_takes_tasks(tmp_path):
    pytest.importorskip("benchmarl")
    from benchmarl.algorithms import MappoConfig
    from benchmarl.experiment import Experiment, ExperimentConfig
    from benchmarl.models import MlpConfig

    from naoisis.benchmarl import MatchTask

    task = MatchTask("TwoOnTwo", {"observation": "belief", "set": SHORT, "max_steps": 12})
    env = task.get_env_fun(2, False, 1, "cpu")()
    assert list(task.state_spec(env).keys()) == ["state"]
    assert [*task.observation_spec(env)["blue"].keys()] == ["observation"]
    assert [*task.info_spec(env)["blue"].keys()] == ["info"] and task.info_spec(env).get("state", None) is None
    assert task.group_map(env) == {"blue": ["blue_1", "blue_2"]} and task.max_steps(env) == 12
    assert task.log_info(env.rollout(12, break_when_any_done=False)) == {"collection/blue/success_rate": 0.0}
    config = ExperimentConfig.get_from_yaml()
    config.max_n_iters, config.max_n_frames, config.loggers, config.create_json = 1, None, [], False
    config.save_folder, config.render = str(tmp_path), False
    config.on_policy_collected_frames_per_batch, config.on_policy_n_envs_per_worker = 40, 2
    config.on_policy_n_minibatch_iters, config.on_policy_minibatch_size, config.evaluation_episodes = 1, 20, 2
    config.evaluation_interval = 40
    model = MlpConfig.get_from_yaml()
    experiment = Experiment(
        task=task,
        algorithm_config=MappoConfig.get_from_yaml(),
        model_config=model,
        critic_model_config=model,
        seed=0,
        config=config,
    )
    experiment.run()
    assert experiment.n_iters_performed == 1


def test_a_reward_of_all_worlds_is_that_of_each_agent():
    reward = naoisis.batch_reward(lambda steps: steps.after[:, 0])
    env = MatchEnv("FirstGoal", num_envs=2, control="blue", observation="truth", action="discrete", reward=reward)
    played = env.rollout(3)
    ball = played["next", "state"][..., 0]
    assert torch.equal(played["next", "blue", "reward"].squeeze(-1), ball[..., None].expand(2, 3, 2))
