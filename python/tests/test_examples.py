"""The examples that need no library of their own, and the policies that others have learned."""

import importlib.util
from pathlib import Path

import gymnasium
import pytest

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


def test_worlds_fill_the_buffers_of_pufferlib():
    soccer = _module(FOLDER / "pufferlib" / "main.py")
    env = soccer.Soccer("TwoOnTwo", worlds=2, observation="truth")
    begun = env.reset(seed=1)[0].copy()
    observations, rewards, *_ = env.step([1, 1, 1, 1])
    assert observations is env.observations and (observations != begun).any() and rewards is env.rewards
    assert soccer.main(5) == soccer.main(5)
