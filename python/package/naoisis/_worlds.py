"""Worlds in which something learns: what the environments of all libraries are made of."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping
from typing import Any

import numpy as np
from gymnasium import spaces

from naoisis import _naoisis
from naoisis._arguments import Scenario, control_of, count_of, match_of, seed_of, word_of

AUTO_RESETS = ("next_step", "same_step", "disabled")


class Worlds:
    """Some worlds, and the arrays that they fill. A row is an agent: those of one world are neighbours."""

    def __init__(
        self,
        scenario: Scenario,
        *,
        control: str | Iterable[str] | None,
        opponents: str | None,
        observation: str,
        action: str,
        reward: Mapping[str, float] | None,
        cycles_per_step: int | None,
        set: Mapping[str, Any] | None,
        realism: str | None,
        camera: str = "top",
        image_size: tuple[int, int] = (48, 64),
        worlds: int = 1,
        auto_reset: str = "disabled",
        threads: int | None = 1,
        solo: bool = False,
    ):
        made = match_of(scenario, None, set, None, None, realism)
        if opponents is not None:
            word_of(opponents, "opponents")
            first = next(iter([control] if isinstance(control, str) else control or ["blue"]), "blue")
            made["pink" if str(first).startswith("blue") else "blue"] = opponents
        if not isinstance(observation, str) or not isinstance(action, str):
            raise TypeError("observation and action: expected texts")
        height, width = image_size
        self.observation, self.action = observation, action
        self.inner = _naoisis.Environments(
            made,
            {
                "control": None if control is None else control_of(control),
                "solo": solo,
                "observation": observation,
                "camera": camera,
                "image_size": [count_of(height, "image_size", most=4096), count_of(width, "image_size", most=4096)],
                "action": action,
                "cycles_per_step": None if cycles_per_step is None else count_of(cycles_per_step, "cycles_per_step"),
                "reward": _weights(reward),
                "worlds": count_of(worlds, "num_envs", most=1_000_000),
                "auto_reset": str(getattr(auto_reset, "name", auto_reset)).lower(),
                "threads": os.cpu_count() or 1 if threads is None else count_of(threads, "threads", most=1024),
            },
        )
        self.agents = self.inner.control
        self.worlds = int(worlds)
        self.rows = self.worlds * len(self.agents)
        entries = self.inner.entries()
        self.observation_names = [name for name, *_ in entries]
        self.observation_entries = entries
        self.action_names = self.inner.action_names()
        self.step_s = self.inner.cycles_per_step * self.inner.cycle_s
        low, high = (np.array([entry[side] for entry in entries], np.float32) for side in (1, 2))
        self.image_shape = (height, width, 3) if observation == "image" else None
        numbers = spaces.Box(low, high, dtype=np.float32)
        self.observation_space: spaces.Space[Any] = numbers
        if self.image_shape:
            self.observation_space = spaces.Dict({"body": numbers, "image": spaces.Box(0, 255, self.image_shape, np.uint8)})
        counts = [len(names) for names in self.action_names]
        self.action_space: spaces.Space[Any]
        if action == "continuous":
            self.action_space = spaces.Box(-1.0, 1.0, (counts[0],), np.float32)
        elif action == "discrete":
            self.action_space = spaces.Discrete(counts[0])
        else:
            self.action_space = spaces.MultiDiscrete(counts)
        self.numbers_of_action = counts[0] if action == "continuous" else len(counts)

    def arrays(self, with_final: bool = False) -> dict[str, np.ndarray]:
        """Fresh arrays that a step fills."""
        rows, length = self.rows, len(self.observation_names)
        image = self.image_shape or (0,)
        finals = rows if with_final else 0
        return {
            "observations": np.zeros((rows, length), np.float32),
            "images": np.zeros((rows if self.image_shape else 0, *image), np.uint8),
            "rewards": np.zeros(rows, np.float32),
            "terminations": np.zeros(rows, np.bool_),
            "truncations": np.zeros(rows, np.bool_),
            "successes": np.zeros(rows, np.bool_),
            "final_observations": np.zeros((finals, length), np.float32),
            "final_images": np.zeros((finals if self.image_shape else 0, *image), np.uint8),
        }

    def actions(self, actions: Any) -> np.ndarray:
        """Actions as the compiled part takes them."""
        try:
            array = np.ascontiguousarray(actions, dtype=np.float32)
        except (TypeError, ValueError) as error:
            raise TypeError(f"actions: expected numbers, {self.rows} rows of {self.numbers_of_action}: {error}") from None
        if array.size != self.rows * self.numbers_of_action:
            shape = (self.rows, self.numbers_of_action)
            raise ValueError(f"actions: an array of shape {array.shape}; expected {shape}")
        return array

    def observations(self, arrays: Mapping[str, np.ndarray], prefix: str = "") -> Any:
        """What agents observe, row by row, as their space has it."""
        if self.image_shape:
            return {"body": arrays[f"{prefix}observations"], "image": arrays[f"{prefix}images"]}
        return arrays[f"{prefix}observations"]

    def row(self, observations: Any, row: int) -> Any:
        """What one agent observes."""
        if self.image_shape:
            return {name: array[row] for name, array in observations.items()}
        return observations[row]

    def reset(self, seed: int | None, arrays: dict[str, np.ndarray], mask: np.ndarray | None = None) -> None:
        """Begins episodes."""
        self.inner.reset(seed_of(seed), mask, arrays)

    def picture(self, size: tuple[int, int] = (540, 960), world: int = 0) -> np.ndarray:
        """The field of a world."""
        height, width = size
        return self.inner.picture(world, width, height)


def _weights(reward: Mapping[str, float] | None) -> dict[str, float] | None:
    if reward is None:
        return None
    if not isinstance(reward, Mapping):
        names = ", ".join(name for name, _ in _naoisis.Environments.rewards())
        raise TypeError(f"reward: expected a dictionary of {names} and their weights, not {reward!r}")
    return {name: float(weight) for name, weight in reward.items()}


def agent_name(robot: str) -> str:
    """The name of a robot as an agent: ``blue_1``."""
    return f"{robot[:4]}_{robot[4:]}"


Reward = Callable[[Mapping[str, Any], str], float]
"""A reward of one's own: of what is true now, as :meth:`naoisis.Match.truth` has it, and the robot's name."""
