"""Scenarios that go on from a saved match."""

import json

import numpy as np
import pytest

import naoisis

SAVED_S = 6.0


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A saved match, and a scenario beside it that goes on from it for three seconds."""
    folder = tmp_path_factory.mktemp("saved")
    match = naoisis.Match("match3v3", seed=3)
    match.run(SAVED_S)
    (folder / "moment.naoisis").write_bytes(match.snapshot())
    (folder / "on.json").write_text(json.dumps({"from": "moment.naoisis", "duration_s": 3}))
    return folder


def _end(scenario, seed=None):
    match = naoisis.Match(scenario, seed=seed)
    begun = match.truth()
    match.run()
    assert match.time_s == SAVED_S + 3
    return begun["robots"], match.truth()["robots"]


def test_a_match_goes_on_from_the_moment_with_the_chance_of_its_seed(folder, monkeypatch):
    now = naoisis.Match.restore((folder / "moment.naoisis").read_bytes()).truth()["robots"]
    first, again, other = (_end(folder / "on.json", seed) for seed in (1, 1, 2))
    assert [robot["pose"] for robot in first[0]] == [robot["pose"] for robot in now]
    assert first == again and first[0] == other[0] and first[1] != other[1]
    # The path in a file is beside the file, that in a dictionary from where one is.
    monkeypatch.chdir(folder)
    assert _end({"from": "moment.naoisis", "duration_s": 3}, 1) == first
    scenario = naoisis.Match(folder / "on.json", seed=1).scenario
    monkeypatch.chdir(folder.parent)
    # It has the saved match in it.
    assert _end(scenario) == first


def test_robots_are_controlled_where_they_are(folder):
    match = naoisis.Match(folder / "on.json", control=["blue2"])
    before = match.truth()["robots"][1]
    match.step({"blue2": {"walk": [0.006, 0, 0]}}, cycles=30)
    after = match.truth()["robots"][1]
    assert before["id"] == "blue2" and match.time_s == SAVED_S + 1
    assert 0.1 < np.hypot(*np.subtract(after["pose"], before["pose"])[:2]) < 0.25
    assert after["command"]["walk"] == [0.006, 0.0, 0.0]


def test_a_batch_plays_the_moment_again_and_again(folder):
    batch = naoisis.batch(folder / "on.json", 3, seed=5, threads=1)
    assert list(batch["seed"]) == [5, 6, 7] and list(batch["duration_s"]) == [3.0] * 3
    alone = naoisis.batch({"from": str(folder / "moment.naoisis"), "duration_s": 3}, 1, seed=6, threads=1)
    assert alone["blue_belief_error_m"][0] == batch["blue_belief_error_m"][1] != batch["blue_belief_error_m"][0]


def test_episodes_begin_in_the_moment_with_other_chance_each_time(folder):
    envs = naoisis.vector_env(
        folder / "on.json", 2, control="blue", observation="perception", autoreset_mode="same_step", threads=1
    )
    first, _ = envs.reset(seed=1)
    begun = envs.state().copy()
    places = [index for index, name in enumerate(envs.state_names) if name.endswith((".x", ".y"))]
    assert envs.agents == ["blue1", "blue2", "blue3"] and np.array_equal(begun[0, places], begun[1, places])
    stand, ends = np.zeros(envs.action_space.shape, np.float32), []
    for _ in range(30):
        seen, _, _, truncations, _ = envs.step(stand)
        ends.append(bool(truncations.all()))
    # Ten actions a second.
    assert ends == [False] * 29 + [True]
    assert np.array_equal(envs.state()[:, places], begun[:, places])
    envs.reset(seed=1, options={"set": {"messages.loss": 1.0}})
    assert np.array_equal(envs.state()[:, places], begun[:, places])
    roles = naoisis.MatchEnv(folder / "on.json", control="blue2", opponents="roles")
    roles.reset(seed=1)
    assert roles.truth()["time_s"] == SAVED_S


@pytest.mark.parametrize(
    ("act", "words"),
    [
        (lambda folder: naoisis.Match({"from": "lost.naoisis"}), "there is no file `lost.naoisis`"),
        (lambda folder: naoisis.batch({"from": str(folder / "on.json")}), "is no saved match"),
        (lambda folder: naoisis.Match(folder / "moment.naoisis"), r"is a saved match; expected a scenario .*'from'"),
        (lambda folder: naoisis.vector_env(str(folder / "moment.naoisis"), 2, control="blue"), "is a saved match"),
        (lambda folder: naoisis.Match("match3v3", set={"from": "moment.naoisis"}), "set: `from` cannot be set"),
        (lambda folder: naoisis.Match(folder / "on.json", realism="realistic"), "`realism` is that of the saved match"),
        (
            lambda folder: naoisis.Match(folder / "on.json", set={"ball.position_m": [1.0, 0.0]}),
            "`ball` is that of the saved",
        ),
        (lambda folder: naoisis.Match(folder / "on.json", control=["blue9"]), "there is no robot `blue9`"),
    ],
)
def test_what_cannot_be_is_said(folder, act, words):
    with pytest.raises(ValueError, match=words):
        act(folder)


@pytest.mark.parametrize("seed", [0, 1, 2**62 - 1, 2**62, 2**63, 2**64 - 1])
def test_a_match_of_any_seed_branches(seed):
    match = naoisis.Match("match3v3", seed=seed)
    match.run(1)
    branch = match.branch()
    match.run(1)
    branch.run(1)
    assert branch.truth() == match.truth()
