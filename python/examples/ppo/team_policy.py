"""A policy for the robots of a team: what it is given, how it decides, and how it does against others. NumPy alone; ``self_play.py`` learns
one with PyTorch."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from adviser import HALF_GOAL_M, KICKS, Adviser, unit

# How much likelier than another the advised choice is as long as nothing has been learned, as a logit: of the three walks, and of the kick.
# Of five choices that takes the advised walk about half of the time, so that all of it is followed in an eighth of the steps.
LEANING = np.repeat(np.array([1.5, 1.5, 1.5, 3.0], np.float32), 5)


class Senses:
    """What a policy is given: a robot's belief, the same as seen from the ball towards the goal, what each kick would do, and advice.

    Args:
        names: The names of the numbers of an observation.
    """

    def __init__(self, names: Sequence[str]):
        self.others = [
            name.removesuffix(".known") for name in names if name.endswith(".known") and name != "ball.known"
        ]
        things = ["ball", "goal", "own_goal", *self.others]
        self.place = {thing: (names.index(f"{thing}.x"), names.index(f"{thing}.y")) for thing in things}
        self.known = {thing: names.index(f"{thing}.known") for thing in self.others}
        self.own = names.index("own.cos"), names.index("own.sin")
        self.adviser = Adviser(names)
        self.numbers = self(np.zeros((1, len(names)), np.float32)).shape[1]

    def __call__(self, observations: np.ndarray) -> np.ndarray:
        """What a network is given of robots that observe this, row by row. Its last numbers are the advice."""
        place = {thing: observations[:, x] + 1j * observations[:, y] for thing, (x, y) in self.place.items()}
        ball, goal = place["ball"], place["goal"]
        aim = unit(goal - ball)
        others = [(place[name] - ball) * aim.conj() * observations[:, self.known[name]] for name in self.others]
        lengths = [np.abs(ball), np.abs(goal - ball), *(np.abs(place[name] - ball) for name in self.others)]
        directions = [unit(ball), aim, unit(ball - place["own_goal"]), unit(ball) * aim.conj(), unit(goal)]
        far = np.stack([*parts([ball * aim.conj(), *others]), *lengths], axis=1)
        near = np.stack([*parts(directions), *self._kicks(observations, ball, goal)], axis=1)
        advice = [np.eye(5)[column] for column in self.adviser(observations).T]
        return np.concatenate(
            [spread(np.concatenate([observations, far], axis=1)), near, *advice], axis=1, dtype=np.float32
        )

    def _kicks(self, observations: np.ndarray, ball: np.ndarray, goal: np.ndarray) -> list[np.ndarray]:
        """Of each kick, whether the ball lies right for it, and by how much it then passes both posts inside, as sines."""
        cos, sin = (observations[:, index] for index in self.own)
        across = 1j * HALF_GOAL_M * (cos - 1j * sin)
        left_post, right_post = unit(goal + across - ball), unit(goal - across - ball)
        numbers = []
        for kick in KICKS.values():
            reached, leaves = kick.reaches(ball), unit(ball - kick.foot).conj()
            numbers += [
                1.0 * reached,
                3.0 * reached * (leaves * left_post).imag,
                -3.0 * reached * (leaves * right_post).imag,
            ]
        return numbers


def parts(numbers: Sequence[np.ndarray]) -> list[np.ndarray]:
    """The real and imaginary parts of complex numbers."""
    return [part for number in numbers for part in (number.real, number.imag)]


def spread(features: np.ndarray) -> np.ndarray:
    """Features as a network likes them: each once as it is, for far things, and once with its small values spread, for near ones."""
    return np.concatenate([np.clip(features / 3, -3, 3), np.arcsinh(20 * features) / 3], axis=1).astype(np.float32)


class TeamPolicy:
    """A policy of a file: decides for robots from their beliefs, row by row, by drawing from what it thinks likely.

    Args:
        path: The file.
        names: The names of the numbers of an observation.
        seed: Of the draw.

    >>> policy = TeamPolicy("policies/FirstGoal-belief.npz", envs.observation_names)
    >>> actions = policy(observations)
    """

    def __init__(self, path: str | os.PathLike[str], names: Sequence[str], seed: int = 1):
        self.random = np.random.default_rng(seed)
        with np.load(path) as file:
            arrays = {name: file[name] for name in file.files}
        # How many choices there are, list by list.
        self.sizes = arrays.pop("sizes")
        arrays = {name: array.astype(np.float32) for name, array in arrays.items()}
        self.layers = [(arrays[f"weight{layer}"], arrays[f"bias{layer}"]) for layer in range(len(arrays) // 2)]
        self.senses = Senses(names)

    def __call__(self, observations: np.ndarray) -> np.ndarray:
        signal = self.senses(observations)
        scores = LEANING * signal[:, -len(LEANING) :]
        for weight, bias in self.layers[:-1]:
            signal = np.tanh(signal @ weight.T + bias)
        weight, bias = self.layers[-1]
        # Gumbel's way of drawing from a softmax.
        scores = scores + signal @ weight.T + bias + self.random.gumbel(size=scores.shape)
        return np.stack([part.argmax(axis=1) for part in np.split(scores, np.cumsum(self.sizes)[:-1], axis=1)], axis=1)


@dataclass(frozen=True)
class Record:
    """How many episodes were won, lost, and neither."""

    won: int
    lost: int
    undecided: int

    @property
    def share(self) -> float:
        """The share of the decided episodes that were won."""
        return self.won / max(self.won + self.lost, 1)

    @property
    def interval(self) -> tuple[float, float]:
        """Wilson's interval of that share, with 95 % confidence."""
        decided, z = max(self.won + self.lost, 1), 1.96
        middle = (self.share + z**2 / (2 * decided)) / (1 + z**2 / decided)
        half = z / (1 + z**2 / decided) * (self.share * (1 - self.share) / decided + z**2 / (4 * decided**2)) ** 0.5
        return middle - half, middle + half

    def __str__(self) -> str:
        low, high = self.interval
        decided = f"{self.won} won, {self.lost} lost, {self.undecided} undecided"
        return f"{decided}: {self.share:.1%} of the decided ones won ({low:.1%} to {high:.1%})"


def play(task: str, policy: Callable[[np.ndarray], np.ndarray], opponents: str, episodes: int, seed: int) -> Record:
    """What comes of so many episodes in which a policy plays a whole team against a built-in one, half of them from each side."""
    import naoisis

    ends: list[float] = []
    for side in ("blue", "pink"):
        # Each world plays as many, so that quick ones do not count more.
        worlds = min(-(-episodes // 2), 25)
        left = np.full(worlds, -(-episodes // (2 * worlds)))
        envs = naoisis.vector_env(
            task,
            worlds,
            control=side,
            opponents=opponents,
            observation="belief",
            action="velocities",
            reward={"score": 1.0},
            autoreset_mode="same_step",
            threads=1,
        )
        seen, _ = envs.reset(seed=seed)
        while (left > 0).any():
            seen, rewards, terminated, truncated, _ = envs.step(policy(seen))
            # Both robots of a world have the same score.
            over, score = (array.reshape(worlds, -1)[:, 0] for array in (terminated | truncated, rewards))
            ends += score[over & (left > 0)].tolist()
            left[over] -= 1
    scores = np.array(ends)
    return Record(int((scores > 0).sum()), int((scores < 0).sum()), int((scores == 0).sum()))
