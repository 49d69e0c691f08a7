"""Environments and batches that are copied, or sent to other processes."""

import copy
import pickle

import numpy as np
import pytest

import naoisis
from naoisis.self_play import SelfPlay

COPIES = [copy.deepcopy, lambda env: pickle.loads(pickle.dumps(env))]


def _same(one, other):
    """Whether results are the same to the last bit."""
    if isinstance(one, dict):
        return one.keys() == other.keys() and all(_same(one[key], other[key]) for key in one)
    if isinstance(one, (list, tuple)):
        return len(one) == len(other) and all(map(_same, one, other))
    if isinstance(one, np.ndarray) and one.dtype != object:
        return one.dtype == other.dtype and np.array_equal(one, other, equal_nan=one.dtype.kind == "f")
    return _same(list(one), list(other)) if isinstance(one, np.ndarray) else one == other


@pytest.mark.parametrize("copied", COPIES)
@pytest.mark.parametrize("observation", ["perception", "belief", "truth", "image"])
def test_a_copy_plays_the_same_episodes_from_the_middle_of_one_on(copied, observation):
    env = naoisis.MatchEnv("TwoOnTwo", observation=observation, set={"duration_s": 3})
    env.reset(seed=5)
    env.action_space.seed(1)
    for _ in range(10):
        env.step(env.action_space.sample())
    other = copied(env)
    over = False
    while not over:
        action = env.action_space.sample()
        one, two = env.step(action), other.step(action)
        assert _same(one, two)
        over = one[2] or one[3]
    # The seeds of the episodes that follow are the same, too.
    assert _same(env.reset(), other.reset())


@pytest.mark.parametrize("mode", ["next_step", "same_step", "disabled"])
def test_many_worlds_are_copied_with_what_their_resets_have_changed(mode):
    options = {"observation": "truth", "autoreset_mode": mode, "opponents": ["roles", "chasers"], "control": "blue"}
    env = naoisis.vector_env("Match3v3", 3, **options, set={"duration_s": 1})
    env.reset(seed=5)
    mask = np.repeat([False, True, False], 3)
    env.reset(options={"set": {"duration_s": 0.5}, "reset_mask": mask})
    env.action_space.seed(1)
    env.step(env.action_space.sample())
    other = pickle.loads(pickle.dumps(env))
    for _ in range(20):
        actions = env.action_space.sample()
        one, two = env.step(actions), other.step(actions)
        assert _same(one, two)
        over = one[2] | one[3]
        if mode == "disabled" and over.any():
            assert _same(env.reset(options={"reset_mask": over}), other.reset(options={"reset_mask": over}))


@pytest.mark.parametrize("copied", COPIES)
def test_an_environment_that_has_not_begun_is_copied(copied):
    pytest.importorskip("pettingzoo")
    for env in (
        naoisis.MatchEnv("FindBall"),
        naoisis.parallel_env("TwoOnTwo"),
        naoisis.vector_env("match3v3", 2, control="blue"),
        SelfPlay("TwoOnTwo", 2),
    ):
        other = copied(env)
        assert _same(env.reset(seed=3), other.reset(seed=3))
    with pytest.raises(naoisis.MatchError, match="has not begun"):
        copied(naoisis.MatchEnv("FindBall")).step(np.zeros(8))


@pytest.mark.parametrize("copied", COPIES)
def test_a_batch_is_copied(copied):
    batch = naoisis.batch("match3v3", 2, duration_s=1, sweep={"messages.loss": [0, 0.5]})
    other = copied(batch)
    assert other.to_csv() == batch.to_csv() and other.summary() == batch.summary() and other.matches == 4
    assert _same(dict(batch), dict(other)) and copied(other).summary() == batch.summary()
