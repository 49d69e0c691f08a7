"""Every player against every other."""

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import naoisis

LEARNED = Path(__file__).parents[2] / "assets/policies/learned.onnx"
SHORT = {"duration_s": 30}


def stand(observations):
    return np.zeros((len(observations), 8), np.float32)


def test_built_in_teams_come_out_as_in_the_command_line():
    words = [
        "batch",
        "match3v3",
        "--matches",
        "4",
        "--seed",
        "3",
        "--duration",
        "30",
        "--pairs",
        "chasers,passers,roles",
    ]
    done = subprocess.run(
        [sys.executable, "-m", "naoisis._command", *words], capture_output=True, text=True, check=True
    )
    teams = {name: name for name in ("chasers", "passers", "roles")}
    found = naoisis.cross_play(teams, "match3v3", 4, seed=3, set=SHORT)
    pairs = 0
    for line in done.stdout.splitlines():
        named = re.match(r"(\w+) (?:and|beats) (\w+): .*4 matches", line)
        if named:
            pairs += 1
            pair = found.against(*named.groups())
            shares = [f"{100 * each.value:.1f} % {what}" for each, what in ((pair.wins, "wins"), (pair.draws, "draws"))]
            goals = f"goals {pair.goals.value:.2f} : {pair.goals_against.value:.2f}, difference"
            assert all(words in line for words in (*shares, goals)), (line, pair)
            assert f"probability of improvement {pair.improvement.value:.2f}" in line
        rated = re.match(r"(\w+) +([+-]\d+) \(", line)
        if rated:
            assert found.ratings[rated[1]].value == pytest.approx(float(rated[2]), abs=0.51)
    assert pairs == 3 and len(found.ratings) == 3
    assert sum(rating.value for rating in found.ratings.values()) == pytest.approx(0.0, abs=1e-6)


def test_functions_files_and_teams_play_each_other_from_both_sides():
    players = {"stand": stand, "learned": LEARNED, "roles": "roles", "again": stand}
    found = naoisis.cross_play(players, "match3v3", 4, set=SHORT, realism="ideal")
    assert len(found.table["seed"]) == 6 * 4 and len(found.to_pandas()) == 24
    rows = list(zip(*(found.table[name].tolist() for name in ("blue", "pink", "seed"))))
    assert rows[:4] == [
        ("stand", "learned", 1),
        ("stand", "learned", 2),
        ("learned", "stand", 1),
        ("learned", "stand", 2),
    ]
    lost = found.against("stand", "roles")
    won = found.against("roles", "stand")
    assert lost.goal_difference.value == -won.goal_difference.value < 0.0
    assert (lost.losses, lost.goals_against, lost.matches) == (won.wins, won.goals, 4)
    assert lost.improvement.value == 1.0 - won.improvement.value
    best = max(found.ratings, key=lambda name: found.ratings[name].value)
    assert best in ("learned", "roles") and best in str(found).splitlines()[6]
    # Nothing happens, and nobody is better.
    alike = found.against("stand", "again")
    assert alike.draws.value == 1.0 and alike.is_first_better is None and alike.improvement.value == 0.5


def test_observations_and_actions_are_those_of_the_options():
    shapes = set()

    def forward(observations):
        shapes.add(observations.shape[1])
        return np.full(len(observations), 1)

    options = {"observation": "belief", "action": "discrete", "set": {"duration_s": 1}}
    found = naoisis.cross_play({"a": forward, "b": forward}, matches=2, **options)
    env = naoisis.MatchEnv("match3v3", control="blue1", observation="belief")
    assert shapes == {len(env.observation_names)} and found.pairs[0].matches == 2


def test_tasks_are_played_by_policies_and_functions():
    found = naoisis.cross_play({"stand": stand, "chasers": "chasers"}, "FirstGoal", 4, realism="ideal")
    assert found.against("chasers", "stand").wins.value > 0.5
    assert set(found.table["winner"].tolist()) <= {"chasers", ""}
    with pytest.raises(ValueError, match="a and b are teams, and FirstGoal is a task; expected a scenario"):
        naoisis.cross_play({"a": "roles", "b": "chasers"}, "FirstGoal", 2)


@pytest.mark.parametrize(
    ("arguments", "error", "words"),
    [
        ({"players": {"a": "roles"}}, ValueError, "players: expected a dictionary of at least two"),
        ({"matches": 3}, ValueError, "matches: 3 is odd"),
        ({"seed": None}, ValueError, "seed: None cannot be the first of 1"),
        ({"control": "blue"}, TypeError, "control and opponents: both teams are played here"),
        ({"players": {"a": "roles", "b": 5}}, TypeError, "players: b: expected an ONNX file"),
        ({"players": {"a": "roles", "b": "role"}}, naoisis.ScenarioError, "did you mean `roles`"),
    ],
)
def test_what_is_wrong_is_named(arguments, error, words):
    with pytest.raises(error, match=words):
        naoisis.cross_play(**{"players": {"a": "roles", "b": "chasers"}, "matches": 2, **arguments})


def test_who_did_not_play_has_no_result():
    found = naoisis.cross_play({"a": stand, "b": stand}, "match3v3", 2, set={"duration_s": 0.5})
    with pytest.raises(KeyError, match="there are no matches of 'a' against 'c'"):
        found.against("a", "c")
