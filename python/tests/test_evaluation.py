"""Evaluations of policies: the episodes, seeds and intervals of `naoisis challenge`."""

import json
import math
import shutil
from pathlib import Path

import numpy as np
import pytest

import naoisis
from naoisis import _naoisis, _statistics

POLICIES = Path(__file__).parents[2] / "assets/policies"


def likeliest(folder, name="score_empty_goal"):
    """Returns a copy of a policy that draws nothing: draws in Python are not those of the match."""
    file = folder / "policy.onnx"
    shutil.copy(POLICIES / f"{name}.onnx", file)
    layout = json.loads((POLICIES / f"{name}.json").read_text())
    file.with_suffix(".json").write_text(json.dumps({**layout, "choice": "likeliest"}))
    return file


def measured(folder, *words):
    """Returns the result that the command line writes."""
    out = folder / "results.json"
    assert _naoisis.command(["naoisis", "challenge", *words, "--out", str(out), "--force", "--quiet"]) == 0
    return json.loads(out.read_text())["results"][0]


@pytest.mark.parametrize(("task", "realism"), [("ScoreEmptyGoal", "paper"), ("ScoreEmptyGoal", "realistic")])
def test_every_episode_is_that_of_the_command_line(tmp_path, task, realism):
    policy = likeliest(tmp_path)
    result = measured(tmp_path, task, "--policy", str(policy), "--episodes", "20", "--realism", realism, "--seed", "5")
    found = naoisis.evaluate(policy, task, 20, seed=5, realism=realism)
    rate = result["rate"]
    assert (found.task, found.episodes, found.successes) == (task, rate["episodes"], rate["successes"])
    assert 0 < found.successes and found.mean_success_s == pytest.approx(rate["mean_time_s"], abs=1e-4)
    for number, episode in enumerate(result["episodes"]):
        row = {name: column[number] for name, column in found.table.items()}
        assert (row["seed"], row["success"]) == (episode["seed"], episode["is_success"])
        assert row["seconds"] == pytest.approx(episode["time_s"], abs=1e-4)


@pytest.mark.parametrize(("name", "task"), [("learned", "TwoOnTwo"), ("striker", "PassAndScore")])
def test_a_policy_plays_with_other_numbers_of_robots_as_in_the_command_line(tmp_path, name, task):
    policy = likeliest(tmp_path, name)
    result = measured(tmp_path, task, "--policy", str(policy), "--episodes", "4", "--realism", "realistic")
    found = naoisis.evaluate(policy, task, 4, realism="realistic")
    assert found.table["success"].tolist() == [episode["is_success"] for episode in result["episodes"]]
    assert found.table["seconds"] == pytest.approx([episode["time_s"] for episode in result["episodes"]], abs=1e-4)


@pytest.mark.parametrize("observation", ["perception", "belief", "truth"])
def test_an_observation_has_as_many_robots_as_are_wanted(observation):
    env = naoisis.MatchEnv("match3v3", control="blue2", observation=observation, observed_robots=(3, 1))
    groups = {name.split(".")[0] for name in env.observation_names}
    assert {"team_mate1", "team_mate3", "opponent1"} <= groups and not groups & {"team_mate4", "opponent2"}
    observation, _ = env.reset(seed=1)
    assert env.observation_space.contains(observation)
    # There are two team-mates.
    assert not observation[
        [index for index, name in enumerate(env.observation_names) if name.startswith("team_mate3.")]
    ].any()
    with pytest.raises(ValueError, match="observed_robots: -1 is out of range; expected 0 to 63"):
        naoisis.MatchEnv("match3v3", control="blue2", observed_robots=(-1, 1))
    with pytest.raises(TypeError, match="observed_robots: expected the numbers of team-mates and of opponents, not 3"):
        naoisis.MatchEnv("match3v3", control="blue2", observed_robots=3)


@pytest.mark.parametrize("task", ["TwoOnTwo", "FirstGoal"])
def test_teams_are_controlled_as_in_the_command_line(tmp_path, task):
    result = measured(tmp_path, task, "--behaviour", "ahead", "--episodes", "4")
    found = naoisis.evaluate(lambda seen: np.eye(8)[np.zeros(len(seen), int)], task, 4)
    assert found.table["success"].tolist() == [episode["is_success"] for episode in result["episodes"]]
    assert found.table["seconds"] == pytest.approx([episode["time_s"] for episode in result["episodes"]], abs=1e-4)


@pytest.mark.parametrize("draws", [False, True])
def test_results_depend_on_seeds_and_not_on_worlds(tmp_path, draws):
    policy = naoisis.Policy(POLICIES / "score_empty_goal.onnx" if draws else likeliest(tmp_path), seed=3)
    one, other = (naoisis.evaluate(policy, episodes=7, seed=0, num_envs=worlds) for worlds in (3, 7))
    assert all(np.array_equal(one.table[name], other.table[name]) for name in one.table)
    assert one.table["seed"].tolist() == list(range(7))
    # Episodes differ in length, and each is counted.
    assert len(set(one.table["steps"].tolist())) > 1
    assert str(one) == str(other) and "of 7 succeed" in str(one)


def test_returns_are_those_of_the_environment(tmp_path):
    policy = naoisis.Policy(likeliest(tmp_path))
    found = naoisis.evaluate(policy, "ScoreEmptyGoal", 2, seed=3)
    for number, seed in enumerate((3, 4)):
        env = naoisis.MatchEnv("ScoreEmptyGoal", observation="belief", action="discrete")
        observation, _ = env.reset(seed=seed)
        total, steps, is_over = 0.0, 0, False
        while not is_over:
            observation, reward, terminated, truncated, info = env.step(policy(observation))
            total, steps, is_over = total + reward, steps + 1, terminated or truncated
        assert found.table["return"][number] == pytest.approx(total, abs=1e-4)
        assert (found.table["steps"][number], found.table["success"][number]) == (steps, info["success"])
    assert found.mean_return.low <= found.mean_return.value <= found.mean_return.high


def test_functions_see_the_robots_that_play():
    rows = []

    def ahead(observations):
        rows.append(len(observations))
        return np.tile(np.array([1, 0, 0, 0, 0, 0, 0, 0], np.float32), (len(observations), 1))

    found = naoisis.evaluate(ahead, "FindBall", 5, num_envs=2, set={"duration_s": 2})
    assert found.episodes == 5 and max(rows) == 2 and min(rows) == 1
    assert sum(rows) == found.table["steps"].sum()


def test_memories_are_those_of_robots_in_their_episodes():
    class Counting:
        """Remembers how many steps a robot has made."""

        seen = []

        def act(self, observations, states):
            states = [(state or 0) + 1 for state in states]
            self.seen.append(states)
            return np.zeros((len(states), 8)), states

    policy = Counting()
    found = naoisis.evaluate(policy, "TwoOnTwo", 3, num_envs=2, set={"duration_s": 1})
    steps = found.table["steps"].tolist()
    last = [max(state) for state in policy.seen]
    assert max(last) == max(steps) and policy.seen[0] == [1, 1, 1, 1]
    assert sum(state.count(1) for state in policy.seen) == 3 * 2


def test_records_have_seeds_of_their_own():
    def stand(observations):
        return np.zeros((len(observations), 8))

    found = naoisis.evaluate(stand, episodes=2, record=True, set={"duration_s": 0.5})
    assert found.table["seed"].tolist() == [naoisis.RECORD_SEED, naoisis.RECORD_SEED + 1]
    assert found.mean_success_s is None and found.success_rate.value == 0.0
    assert len(found.to_pandas()) == 2
    last = naoisis.evaluate(stand, episodes=1, seed=2**64 - 1, set={"duration_s": 0.5})
    assert last.table["seed"].tolist() == [2**64 - 1]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"policy": "roles"}, "policy: 'roles' is no policy; expected an ONNX file"),
        ({"policy": 5}, "policy: expected an ONNX file, a naoisis.Policy, or a function of observations, not 5"),
        ({"episodes": 0}, "episodes: 0 is out of range"),
        ({"seed": 1, "record": True}, "seed: 1, and record"),
        ({"seed": 2**64 - 1, "episodes": 2}, "are out of range"),
        ({"policy": lambda seen: np.zeros(3)}, r"policy: the shape of its actions is \(3,\); expected \(1, 8\)"),
    ],
)
def test_what_is_wrong_is_named(arguments, words):
    with pytest.raises((TypeError, ValueError), match=words):
        naoisis.evaluate(**{"policy": lambda seen: np.zeros((len(seen), 8)), "episodes": 1, **arguments})


def test_intervals_are_those_of_the_command_line():
    summary = naoisis.batch("match3v3", 6, set={"duration_s": 30}, realism="ideal").summary()[0]
    played = naoisis.batch("match3v3", 6, set={"duration_s": 30}, realism="ideal")
    for name, found in (
        ("draws", _statistics.share(sum(str(winner) == "nan" or not winner for winner in played["winner"]), 6)),
        ("goal_difference", _statistics.mean(played["blue_goals"] - played["pink_goals"])),
        ("blue_possession", _statistics.mean(played["blue_possession"])),
    ):
        assert vars(found) == pytest.approx(summary[name], abs=1e-9), name


def test_the_bootstrap_of_a_mean_is_about_students_interval():
    values = np.random.default_rng(1).normal(5.0, 2.0, 200)
    [found] = _statistics.bootstrap([values], _statistics.mean_of_samples)
    expected = _statistics.mean(values)
    assert found.value == pytest.approx(expected.value)
    assert found.low == pytest.approx(expected.low, abs=0.05) and found.high == pytest.approx(expected.high, abs=0.05)
    [one] = _statistics.bootstrap([[2.0]], _statistics.mean_of_samples)
    assert (one.value, one.high) == (2.0, math.inf)
    assert f"{_statistics.share(8, 10):.2f}" == "0.80 (0.49 to 0.94)"


def test_the_extras_of_a_policy_are_those_of_its_environment(tmp_path):
    for suffix in (".onnx", ".json"):
        shutil.copy(POLICIES / f"passers_clone{suffix}", tmp_path / f"policy{suffix}")
    layout = json.loads((tmp_path / "policy.json").read_text())
    layout |= {"extras": {"tracked": True}, "choice": "likeliest"}
    (tmp_path / "policy.json").write_text(json.dumps(layout))
    same = {"set": {"duration_s": 20}, "reward": {"to_ball": 1.0, "ball_to_goal": 1.0}}
    tables = [
        naoisis.evaluate(tmp_path / "policy.onnx", "Match3v3", 2, **same, **options).table["return"]
        for options in ({}, {"extras": ["tracked"]}, {"extras": []})
    ]
    assert np.array_equal(tables[0], tables[1]) and not np.array_equal(tables[0], tables[2])
