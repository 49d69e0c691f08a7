"""Features and inference of the policies that ``self_play.py`` trains, and their results against built-in teams. Needs only NumPy and
naoisis."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from adviser import HALF_GOAL_M, KICKS, Adviser, unit

# What is added to the logit of the advised choice, in each of the four lists of five choices: walk forward, walk left, turn, and kick. With
# equal other logits, each advised walk is drawn in about half of the steps and the advised kick in five sixths, all four together in an
# eighth.
ADVICE_LOGITS = np.repeat(np.array([1.5, 1.5, 1.5, 3.0], np.float32), 5)


class Senses:
    """Computes the features of a policy: the observation, positions relative to the ball in the direction of the goal, the result of each
    kick, and the adviser's choices.

    Args:
        names: The names of the observation's columns.
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
        """Returns the features, one row for each robot. The last 20 columns are the advised choices, one-hot, in four lists of five."""
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
        """Returns three columns for each kick: whether its foot reaches the ball and, if so, three times the sines of the angles between
        the ball's direction and the left and right post, positive inside the goal."""
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
    """Returns the real and imaginary parts of complex arrays, alternately."""
    return [part for number in numbers for part in (number.real, number.imag)]


def spread(features: np.ndarray) -> np.ndarray:
    """Returns each feature twice: linear and clipped, to resolve large values, and logarithmically compressed, to resolve small ones."""
    return np.concatenate([np.clip(features / 3, -3, 3), np.arcsinh(20 * features) / 3], axis=1).astype(np.float32)


class TeamPolicy:
    """A trained policy: returns actions for observations of beliefs, one row for each robot, drawn from the policy's distribution.

    Args:
        path: The file that ``self_play.py`` wrote.
        names: The names of the observation's columns.
        seed: The seed of the draws.

    >>> policy = TeamPolicy("policies/FirstGoal-belief.npz", envs.observation_names)
    >>> actions = policy(observations)
    """

    def __init__(self, path: str | os.PathLike[str], names: Sequence[str], seed: int = 1):
        self.random = np.random.default_rng(seed)
        with np.load(path) as file:
            arrays = {name: file[name] for name in file.files}
        # The number of choices in each list.
        self.sizes = arrays.pop("sizes")
        arrays = {name: array.astype(np.float32) for name, array in arrays.items()}
        self.layers = [(arrays[f"weight{layer}"], arrays[f"bias{layer}"]) for layer in range(len(arrays) // 2)]
        self.senses = Senses(names)

    def __call__(self, observations: np.ndarray) -> np.ndarray:
        signal = self.senses(observations)
        scores = ADVICE_LOGITS * signal[:, -len(ADVICE_LOGITS) :]
        for weight, bias in self.layers[:-1]:
            signal = np.tanh(signal @ weight.T + bias)
        weight, bias = self.layers[-1]
        # The Gumbel-max trick: the index of the largest sum of logit and Gumbel noise is a sample from the softmax.
        scores = scores + signal @ weight.T + bias + self.random.gumbel(size=scores.shape)
        return np.stack([part.argmax(axis=1) for part in np.split(scores, np.cumsum(self.sizes)[:-1], axis=1)], axis=1)


@dataclass(frozen=True)
class Record:
    """The numbers of episodes that were won, lost, and undecided."""

    won: int
    lost: int
    undecided: int

    @property
    def share(self) -> float:
        """The share of won episodes among the decided ones (won or lost)."""
        return self.won / max(self.won + self.lost, 1)

    @property
    def interval(self) -> tuple[float, float]:
        """The 95 % Wilson confidence interval of ``share``."""
        decided, z = max(self.won + self.lost, 1), 1.96
        middle = (self.share + z**2 / (2 * decided)) / (1 + z**2 / decided)
        half = z / (1 + z**2 / decided) * (self.share * (1 - self.share) / decided + z**2 / (4 * decided**2)) ** 0.5
        return middle - half, middle + half

    def __str__(self) -> str:
        low, high = self.interval
        decided = f"{self.won} won, {self.lost} lost, {self.undecided} undecided"
        return f"{decided}: {self.share:.1%} of the decided ones won ({low:.1%} to {high:.1%})"


def play(task: str, policy: Callable[[np.ndarray], np.ndarray], opponents: str, episodes: int, seed: int) -> Record:
    """Returns the record of ``policy``, which controls a whole team, in at least ``episodes`` episodes of ``task`` against the built-in
    team ``opponents``.

    It plays half of the episodes as blue and half as pink. ``seed`` is the seed of the first world.
    """
    import naoisis

    ends: list[float] = []
    for side in ("blue", "pink"):
        # Each world plays the same number of episodes: otherwise, short episodes would be overrepresented.
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
            # Both robots of a team get the same reward, so that of the first one suffices.
            over, score = (array.reshape(worlds, -1)[:, 0] for array in (terminated | truncated, rewards))
            ends += score[over & (left > 0)].tolist()
            left[over] -= 1
    scores = np.array(ends)
    return Record(int((scores > 0).sum()), int((scores < 0).sum()), int((scores == 0).sum()))
