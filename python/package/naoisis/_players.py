"""Whole episodes that policies play, many at the same time, with the seeds that are wanted."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from naoisis._arguments import LARGEST_SEED
from naoisis._policies import Policy
from naoisis._worlds import Worlds

MOST_WORLDS = 16


class PolicyWithMemory(Protocol):
    """What decides for robots and remembers something of each."""

    def act(self, observations: Any, states: list[Any], /) -> tuple[Any, list[Any]]:
        """Returns the actions of several robots, and the memory of each after them; it is empty at the start of an episode."""


AnyPolicy = str | os.PathLike[str] | Policy | Callable[[Any], Any] | PolicyWithMemory
"""An ONNX file, a :class:`naoisis.Policy`, a function from observations to actions, row by row, or an object with a memory."""


def policy_of(policy: AnyPolicy, name: str = "policy") -> Policy | Callable[[Any], Any] | PolicyWithMemory:
    """The policy of a file, or what was given."""
    if isinstance(policy, (str, os.PathLike)):
        if not os.fspath(policy).endswith(".onnx"):
            raise ValueError(f"{name}: {os.fspath(policy)!r} is no policy; expected an ONNX file, or a function")
        return Policy(policy)
    if not callable(policy) and not callable(getattr(policy, "act", None)):
        raise TypeError(
            f"{name}: expected an ONNX file, a naoisis.Policy, or a function of observations, not {policy!r}"
        )
    return policy


def layout_of(policy: Any) -> dict[str, Any]:
    """The options of the environment for which a policy was made; empty if it does not say that."""
    if not isinstance(policy, Policy):
        return {}
    extras = dict(policy.layout.get("extras", {}))
    words = extras.pop("words", 0)
    robots = [policy.layout[name] for name in ("team_mates", "opponents") if name in policy.layout]
    return {
        **{name: policy.layout[name] for name in ("observation", "action", "cycles_per_step")},
        **({"observed_robots": tuple(robots)} if robots else {}),
        "extras": [name for name, is_there in extras.items() if is_there],
        "says": words,
    }


class Player:
    """Decides for the robots of some rows by a policy, and keeps the memory of each until its episode ends."""

    def __init__(self, policy: Any, name: str = "policy"):
        self._policy, self._name = policy, name
        # One that can be called has no memory of its own, unless it is of this package.
        self._remembers = isinstance(policy, Policy) or not callable(policy)
        self._states: dict[int, Any] = {}
        self._randoms: dict[int, np.random.Generator] = {}

    def begin(self, rows: Sequence[int], seed: int) -> None:
        """Begins the episode with this seed in these rows, which are the robots of a world."""
        for robot, row in enumerate(rows):
            self._states.pop(row, None)
            if isinstance(self._policy, Policy):
                self._randoms[row] = self._policy.random_of(seed, robot)

    def act(self, observations: Any, rows: np.ndarray, actions: np.ndarray) -> None:
        """Fills in the actions of these rows of robots."""
        seen: Any
        if isinstance(observations, dict):
            seen = {name: array[rows] for name, array in observations.items()}
        else:
            seen = observations[rows]
        if self._remembers:
            randoms = [[self._randoms[row] for row in rows.tolist()]] if self._randoms else []
            answer, states = self._policy.act(seen, [self._states.get(row, []) for row in rows.tolist()], *randoms)
            self._states.update(zip(rows.tolist(), states))
        else:
            answer = self._policy(seen)
        array, shape = np.asarray(answer), actions[rows].shape
        if array.size != int(np.prod(shape)):
            raise ValueError(f"{self._name}: the shape of its actions is {array.shape}; expected {shape}")
        actions[rows] = array.reshape(shape)


@dataclass(frozen=True)
class Ended:
    """An episode that has just ended.

    Attributes:
        number: Its number, from 0.
        steps: The number of steps.
        returns: The sum of the rewards of each agent.
        successes: Whether it was a success of each agent's team.
        truth: What was true at its end.
    """

    number: int
    steps: int
    returns: np.ndarray
    successes: np.ndarray
    truth: dict[str, Any]


def play(worlds: Worlds, players: Sequence[Player], first_seed: int, episodes: int) -> Iterator[Ended]:
    """Plays exactly the episodes with the seeds from ``first_seed`` on, and yields them as they end.

    A world begins the next episode that nobody has begun, so short episodes are not preferred; what comes of an episode does not depend on
    the number of worlds.

    Args:
        worlds: Worlds that are not reset by themselves.
        players: One for each agent of a world. Several agents can have the same.
    """
    agents = len(worlds.agents)
    # Worlds that have not begun are stepped, too.
    arrays = {name: np.zeros_like(array) for name, array in worlds.arrays().items()}
    actions = np.zeros((worlds.rows, worlds.numbers_of_action), np.float32)
    playing = np.full(worlds.worlds, -1)
    steps = np.zeros(worlds.worlds, int)
    returns = np.zeros((worlds.worlds, agents))
    of_players: dict[int, tuple[Player, np.ndarray]] = {}
    for agent, player in enumerate(players):
        _, mine = of_players.setdefault(id(player), (player, np.zeros(agents, bool)))
        mine[agent] = True
    next_one = 0

    def begin(world: int) -> None:
        nonlocal next_one
        # A world that has nothing left to play idles in an episode that nobody counts.
        playing[world], steps[world], returns[world] = (next_one if next_one < episodes else -1), 0, 0.0
        mask = np.zeros(worlds.worlds, bool)
        mask[world] = True
        # The first world gets the seed, and each further one the next.
        seed = first_seed + min(next_one, episodes - 1)
        worlds.reset((seed - world) % (LARGEST_SEED + 1), arrays, None, mask)
        next_one += 1
        rows = range(world * agents, (world + 1) * agents)
        for player, _ in of_players.values():
            player.begin(rows, seed)

    for world in range(worlds.worlds):
        begin(world)
    while (playing >= 0).any():
        actions[...] = 0.0
        observations = worlds.observations(arrays)
        for player, mine in of_players.values():
            rows = np.flatnonzero((playing >= 0)[:, None] & mine[None])
            player.act(observations, rows, actions)
        worlds.step(actions, arrays)
        steps += 1
        returns += arrays["rewards"].reshape(worlds.worlds, agents)
        over = (arrays["terminations"] | arrays["truncations"]).reshape(worlds.worlds, agents)[:, 0]
        for world in np.flatnonzero(over).tolist():
            if playing[world] >= 0:
                successes = arrays["successes"].reshape(worlds.worlds, agents)[world].copy()
                truth = worlds.inner.truth(world)
                yield Ended(int(playing[world]), int(steps[world]), returns[world].copy(), successes, truth)
            begin(world)
