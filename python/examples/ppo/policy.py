"""A learned policy: what it is given, and how it decides. NumPy alone; ``main.py`` learns one with PyTorch."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import Any, Protocol

import numpy as np

FORGOTTEN_S = 10.0
STEP_S = 0.1


class Senses:
    """What a policy is given: the observation, and beside it where things were seen last, carried along by the robot's own steps.

    Of beliefs nothing needs to be remembered: the estimator has done so. The memory of a robot is a row for each thing: where it
    is, m, and how long ago it was seen, s.
    """

    def __init__(self, names: Sequence[str]):
        self.things = [name.removesuffix(".seen") for name in names if name.endswith(".seen")]
        columns = [[names.index(f"{thing}.{what}") for thing in self.things] for what in ("seen", "x", "y")]
        self.seen, *self.place = (np.array(indices, int) for indices in columns)
        self.step = [names.index(f"step.{what}") for what in ("x", "y", "turn")] if self.things else []
        self.numbers = len(names) + 3 * len(self.things)

    def begin(self, rows: int) -> np.ndarray:
        """The memory of so many robots that have seen nothing yet."""
        memory = np.zeros((rows, len(self.things), 3), np.float32)
        memory[..., 2] = FORGOTTEN_S
        return memory

    def __call__(self, observations: np.ndarray, memory: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The features of robots that observe this, and what they remember then."""
        if not self.things:
            return observations, memory
        x, y, turn = (observations[:, index, None] for index in self.step)
        ahead, left = memory[..., 0] - x, memory[..., 1] - y
        cos, sin = np.cos(turn), np.sin(turn)
        age = np.minimum(memory[..., 2] + STEP_S, FORGOTTEN_S)
        carried = np.stack([cos * ahead + sin * left, cos * left - sin * ahead, age], axis=-1)
        carried[age >= FORGOTTEN_S, :2] = 0.0
        places = [observations[:, columns] for columns in self.place]
        now = np.stack([*places, np.zeros_like(places[0])], axis=-1)
        memory = np.where(observations[:, self.seen, None] > 0.5, now, carried).astype(np.float32)
        rows = len(observations)
        return np.concatenate([observations, memory.reshape(rows, -1)], axis=1), memory


def spread(features: np.ndarray) -> np.ndarray:
    """Features as a network likes them: each once as it is, for far things, and once with its small values spread, for near ones."""
    return np.concatenate([np.clip(features / 3, -3, 3), np.arcsinh(20 * features) / 3], axis=1).astype(np.float32)


class Policy(Protocol):
    """What decides for robots from their observations, row by row."""

    def __call__(self, observations: np.ndarray) -> np.ndarray: ...

    def begin(self, over: np.ndarray) -> None:
        """The episodes of these rows are over."""


class Learned:
    """A policy of a file: decides for robots from their observations, row by row, and remembers for each what it needs.

    It draws its actions by their probabilities, as it did when it learned: who always does the likeliest may do it for ever.

    >>> policy = Learned("policies/ScoreEmptyGoal-belief.npz", envs.observation_names)
    >>> actions = policy(observations)
    """

    def __init__(self, path: str | os.PathLike[str], names: Sequence[str], seed: int = 1):
        self.senses, self.random = Senses(names), np.random.default_rng(seed)
        with np.load(path) as file:
            self.layers = [(file[f"weight{layer}"], file[f"bias{layer}"]) for layer in range(len(file.files) // 2)]
        self.memory = self.senses.begin(0)

    def begin(self, over: np.ndarray) -> None:
        """Forgets what the robots of these rows remember: their episodes are over."""
        self.memory[over] = self.senses.begin(int(over.sum()))

    def __call__(self, observations: np.ndarray) -> np.ndarray:
        if len(self.memory) != len(observations):
            self.memory = self.senses.begin(len(observations))
        features, self.memory = self.senses(observations, self.memory)
        signal = spread(features)
        for weight, bias in self.layers[:-1]:
            signal = np.tanh(signal @ weight.T + bias)
        weight, bias = self.layers[-1]
        # Gumbel's way of drawing from a softmax.
        return np.argmax(signal @ weight.T + bias + self.random.gumbel(size=(len(signal), len(bias))), axis=1)


def success_rate(
    task: str, observation: str, policy: Policy, episodes: int, seed: int = 1_000_000, **options: Any
) -> float:
    """The share of so many episodes that are a success. The options are those of the worlds."""
    import naoisis

    options = {"observation": observation, "action": "discrete", "autoreset_mode": "same_step", **options}
    envs = naoisis.vector_env(task, min(episodes, 32), **options)
    seen, _ = envs.reset(seed=seed)
    # Each world plays as many, so that quick ones do not count more.
    left = np.full(envs.num_envs, -(-episodes // envs.num_envs))
    ends: list[bool] = []
    while (left > 0).any():
        seen, _, terminated, truncated, info = envs.step(policy(seen))
        over = terminated | truncated
        if over.any():
            ends += info["final_info"]["success"][over & (left > 0)].tolist()
            left[over] -= 1
            policy.begin(over)
    return float(np.mean(ends))
