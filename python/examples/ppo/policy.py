"""Features and inference of the policies that ``main.py`` trains, and their success rate. Needs only NumPy and naoisis."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import Any, Protocol

import numpy as np

# The age at which a remembered position is forgotten, and the duration of a step, s.
FORGOTTEN_S = 10.0
STEP_S = 0.1


class Senses:
    """Computes the features of a policy: the observation and, if it is a ``perception``, the last seen position of each object, corrected
    by odometry.

    Observations of beliefs need no memory, because the built-in estimator has one. The memory has the shape (robots, objects, 3): the
    position of each object, robot frame, m, and the time since it was last seen, s.

    Args:
        names: The names of the observation's columns.
    """

    def __init__(self, names: Sequence[str]):
        self.things = [name.removesuffix(".seen") for name in names if name.endswith(".seen")]
        columns = [[names.index(f"{thing}.{what}") for thing in self.things] for what in ("seen", "x", "y")]
        self.seen, *self.place = (np.array(indices, int) for indices in columns)
        self.step = [names.index(f"step.{what}") for what in ("x", "y", "turn")] if self.things else []
        self.numbers = len(names) + 3 * len(self.things)

    def begin(self, rows: int) -> np.ndarray:
        """Returns the memory of ``rows`` robots at the start of an episode, when nothing has been seen."""
        memory = np.zeros((rows, len(self.things), 3), np.float32)
        memory[..., 2] = FORGOTTEN_S
        return memory

    def __call__(self, observations: np.ndarray, memory: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Returns the features and the updated memory, one row for each robot."""
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
    """Returns each feature twice: linear and clipped, to resolve large values, and logarithmically compressed, to resolve small ones."""
    return np.concatenate([np.clip(features / 3, -3, 3), np.arcsinh(20 * features) / 3], axis=1).astype(np.float32)


class Policy(Protocol):
    """A policy: returns the actions for ``observations``, one row for each robot. It may have a memory."""

    def __call__(self, observations: np.ndarray) -> np.ndarray: ...

    def begin(self, over: np.ndarray) -> None:
        """Clears the memory of the robots whose episodes are over. ``over`` is a boolean mask of the rows."""


class Learned:
    """A trained policy: returns the actions for observations, one row for each robot, and keeps a memory for each.

    Actions are drawn from the policy's distribution, as in training. A policy that always took the most probable action could repeat it for
    ever.

    Args:
        path: The file that ``main.py`` wrote.
        names: The names of the observation's columns.
        seed: The seed of the draws.

    >>> policy = Learned("policies/ScoreEmptyGoal-belief.npz", envs.observation_names)
    >>> actions = policy(observations)
    """

    def __init__(self, path: str | os.PathLike[str], names: Sequence[str], seed: int = 1):
        self.senses, self.random = Senses(names), np.random.default_rng(seed)
        with np.load(path) as file:
            self.layers = [(file[f"weight{layer}"], file[f"bias{layer}"]) for layer in range(len(file.files) // 2)]
        self.memory = self.senses.begin(0)

    def begin(self, over: np.ndarray) -> None:
        """Clears the memory of the robots whose episodes are over. ``over`` is a boolean mask of the rows."""
        self.memory[over] = self.senses.begin(int(over.sum()))

    def __call__(self, observations: np.ndarray) -> np.ndarray:
        if len(self.memory) != len(observations):
            self.memory = self.senses.begin(len(observations))
        features, self.memory = self.senses(observations, self.memory)
        signal = spread(features)
        for weight, bias in self.layers[:-1]:
            signal = np.tanh(signal @ weight.T + bias)
        weight, bias = self.layers[-1]
        # The Gumbel-max trick: the index of the largest sum of logit and Gumbel noise is a sample from the softmax.
        return np.argmax(signal @ weight.T + bias + self.random.gumbel(size=(len(signal), len(bias))), axis=1)


def success_rate(
    task: str, observation: str, policy: Policy, episodes: int, seed: int = 1_000_000, **options: Any
) -> float:
    """Returns the share of successful ones among at least ``episodes`` episodes of ``task``. ``options`` are those of
    :func:`naoisis.vector_env`."""
    import naoisis

    options = {"observation": observation, "action": "discrete", "autoreset_mode": "same_step", **options}
    envs = naoisis.vector_env(task, min(episodes, 32), **options)
    seen, _ = envs.reset(seed=seed)
    # Each world plays the same number of episodes: otherwise, short episodes would be overrepresented.
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
