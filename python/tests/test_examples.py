"""The examples that need no library of their own, and the policies that others have learned."""

import importlib
import importlib.util
from pathlib import Path

import gymnasium
import pytest

import naoisis

FOLDER = Path(__file__).parent.parent / "examples"


def _module(path):
    spec = importlib.util.spec_from_file_location(path.stem, path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize(("observation", "least"), [("belief", 0.75), ("perception", 0.75)])
def test_what_was_learned_scores(observation, least):
    """More than nine in ten do; what a policy has learned is worth little if the task has changed since."""
    policy = _module(FOLDER / "ppo" / "policy.py")
    names = gymnasium.make("naoisis/ScoreEmptyGoal-v0", observation=observation).unwrapped.observation_names
    learned = policy.Learned(FOLDER / "ppo" / "policies" / f"ScoreEmptyGoal-{observation}.npz", names)
    assert policy.success_rate("ScoreEmptyGoal", observation, learned, 32, seed=7_000) >= least


def test_what_was_learned_by_self_play_wins_against_chasers(monkeypatch):
    """Of those that are decided it wins 64 in 100, and before it has learned none: 50 episodes tell these apart, also where chance falls otherwise."""
    monkeypatch.syspath_prepend(FOLDER / "ppo")
    team = importlib.import_module("team_policy")
    names = naoisis.MatchEnv("FirstGoal", observation="belief").observation_names
    policy = team.TeamPolicy(FOLDER / "ppo" / "policies" / "FirstGoal-belief.npz", names)
    record = team.play("FirstGoal", policy, "chasers", 50, seed=7_000)
    assert record.won + record.lost + record.undecided == 50
    assert record.share > 0.3 and record.won + record.lost > 20, record


def test_worlds_fill_the_buffers_of_pufferlib():
    soccer = _module(FOLDER / "pufferlib" / "main.py")
    env = soccer.Soccer("TwoOnTwo", worlds=2, observation="truth")
    begun = env.reset(seed=1)[0].copy()
    observations, rewards, *_ = env.step([1, 1, 1, 1])
    assert observations is env.observations and (observations != begun).any() and rewards is env.rewards
    assert soccer.main(5) == soccer.main(5)
