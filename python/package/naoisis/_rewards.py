"""Rewards of one's own, computed for all worlds at once."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

__all__ = ["BatchReward", "Steps", "batch_reward"]


@dataclass(frozen=True)
class Steps:
    """One step of all worlds, for a reward that is computed for all of them at once.

    Attributes:
        before: The true states before the step: ``float32`` (worlds, numbers), in the frame of the blue team.
        after: The true states after it. At the end of an episode it is the last state, also where the next episode begins in the same step.
        names: The names of the numbers of a state.
        agents: The robots of each world.
        actions: ``float32`` (worlds, agents, numbers of an action).
        terminated: Whether the task of each world has ended.
        truncated: Whether the time limit has ended the episode of each world.
        success: Whether it ended with success for the team of each agent: ``bool`` (worlds, agents).
        seconds: The duration of a full step, s.
    """

    before: np.ndarray
    after: np.ndarray
    names: Sequence[str]
    agents: Sequence[str]
    actions: np.ndarray
    terminated: np.ndarray
    truncated: np.ndarray
    success: np.ndarray
    seconds: float

    def column(self, name: str) -> tuple[np.ndarray, np.ndarray]:
        """A number of the state of each world before and after the step, such as ``"ball.x"``."""
        if name not in self.names:
            raise KeyError(f"there is no {name!r} in the state; expected one of {', '.join(self.names)}")
        index = list(self.names).index(name)
        return self.before[:, index], self.after[:, index]


class BatchReward:
    """A reward that is computed for all worlds at once: see :func:`batch_reward`."""

    def __init__(self, function: Callable[[Steps], Any]):
        if not callable(function):
            raise TypeError(f"reward: expected a function of steps, not {function!r}")
        self.function = function
        self.__module__ = getattr(function, "__module__", __name__)
        self.__qualname__ = getattr(function, "__qualname__", "")

    def __reduce__(self) -> Any:
        # A function that was decorated is not found by its own name: its reward is there.
        found: Any = sys.modules.get(self.__module__)
        for name in self.__qualname__.split("."):
            found = getattr(found, name, None)
        return self.__qualname__ if found is self else (BatchReward, (self.function,))

    def of(self, steps: Steps) -> np.ndarray:
        """The rewards of all agents: ``float32`` (worlds, agents).

        Raises:
            ValueError: The function returns another shape, or numbers that are not finite.
        """
        worlds, agents = steps.success.shape
        given = self.function(steps)
        try:
            rewards = np.asarray(given)
        except ValueError:
            rewards = np.asarray(None)
        if rewards.dtype.kind not in "biuf":
            raise TypeError(f"reward: the function returned {given!r}; expected an array of numbers")
        rewards = rewards.astype(np.float32)
        if rewards.shape == (worlds,):
            rewards = np.repeat(rewards[:, None], agents, axis=1)
        if rewards.shape != (worlds, agents):
            raise ValueError(
                f"reward: the function returned an array of shape {rewards.shape}; expected ({worlds}, {agents}) or ({worlds},)"
            )
        if not np.isfinite(rewards).all():
            raise ValueError("reward: the function returned a number that is not finite")
        return rewards


def read_only(array: np.ndarray) -> np.ndarray:
    """A view of an array that cannot be written to."""
    view = array.view()
    view.setflags(write=False)
    return view


def batch_reward(function: Callable[[Steps], Any]) -> BatchReward:
    """Makes a reward of a function of :class:`Steps`, which is called once in each step of all worlds.

    >>> @naoisis.batch_reward
    ... def nearer(steps):
    ...     before, after = steps.column("ball.x")
    ...     return after - before + 10 * steps.success[:, 0]
    >>> envs = naoisis.vector_env("ScoreEmptyGoal", 64, reward=nearer, autoreset_mode="same_step")

    The function returns one reward for each agent, ``(worlds, agents)``, or one for each world, ``(worlds,)``, for all of its agents.
    """
    return BatchReward(function)
