"""Self-play: one team learns, and earlier policies play the other.

>>> from naoisis.self_play import SelfPlay
>>> envs = SelfPlay("TwoOnTwo", num_envs=64, observation="belief", action="discrete")
>>> observations, _ = envs.reset(seed=1)
>>> observations, rewards, *_ = envs.step(envs.action_space.sample())
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import gymnasium
import numpy as np
from gymnasium.vector import AutoresetMode
from gymnasium.vector.utils import batch_space, create_empty_array

from naoisis._arguments import Scenario
from naoisis._policies import Policy as LearnedPolicy
from naoisis.environments import VectorEnv
from naoisis.errors import MatchError

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from naoisis._worlds import CommonOptions

__all__ = ["Policy", "SelfPlay"]

Policy = Callable[[Any], Any]
"""What decides for robots: from their observations, row by row, to their actions."""


class SelfPlay(gymnasium.vector.VectorEnv):
    """Many worlds that are stepped together, in which one team learns and a policy from a pool, drawn for each episode, plays the other.

    Every observation is in the frame of its team, so a policy can play either team without changes. The pool starts with
    a policy that stands still; :meth:`add` adds others. Episodes start as in the mode ``same_step`` of :class:`naoisis.VectorEnv`.

    Args:
        team: The team that learns.
        seed: The seed of the draw of policies.
        options: As of :class:`naoisis.VectorEnv`, except ``control`` and ``opponents``, which this class sets.

    Attributes:
        pool: The policies, from which each world draws one when an episode starts; the first one stands still.
        drawn: The index in the pool of each world's policy.
    """

    metadata = {"render_modes": ["rgb_array"], "autoreset_mode": AutoresetMode.SAME_STEP}

    def __init__(
        self,
        scenario: Scenario = "TwoOnTwo",
        num_envs: int = 1,
        *,
        observation: str = "perception",
        team: str = "blue",
        seed: int | None = None,
        threads: int | None = None,
        render_mode: str | None = None,
        **options: Unpack[CommonOptions],
    ):
        if team not in ("blue", "pink"):
            raise ValueError(f"team: there is no {team!r}; expected 'blue' or 'pink'")
        if "control" in options or "opponents" in options:
            raise TypeError("control and opponents: both teams are played here; expected neither")
        self.envs = VectorEnv(
            scenario,
            num_envs,
            control=["blue", "pink"],
            observation=observation,
            autoreset_mode="same_step",
            threads=threads,
            render_mode=render_mode,
            **options,
        )
        learns = np.array([robot.startswith(team) for robot in self.envs.agents])
        self._learns = np.tile(learns, self.envs.num_worlds)
        self._world = np.repeat(np.arange(self.envs.num_worlds), len(learns))
        self.num_worlds, self.num_envs = self.envs.num_worlds, int(self._learns.sum())
        self.agents = [robot for robot in self.envs.agents if robot.startswith(team)]
        self.render_mode = render_mode
        self.single_observation_space = self.envs.single_observation_space
        self.single_action_space = self.envs.single_action_space
        self.observation_space = batch_space(self.single_observation_space, self.num_envs)
        self.action_space = batch_space(self.single_action_space, self.num_envs)
        self.observation_names, self.action_names = self.envs.observation_names, self.envs.action_names
        self.state_names, self.state_space = self.envs.state_names, self.envs.state_space
        self.pool: list[Policy] = [self._stand]
        self._random = np.random.default_rng(seed)
        self.drawn = np.zeros(self.num_worlds, int)
        self._seen: Any = None
        # The recurrent state of each robot that a learned policy plays.
        self._states: list[Any] = [[] for _ in self._world]

    def add(self, policy: Policy) -> None:
        """Adds a policy to the pool. It is called with the observations of some robots, and returns their actions.

        The robots differ from step to step, so a policy with a memory has to be a :class:`naoisis.Policy`: the memory of each of its robots
        is kept until its episode ends.
        """
        if not callable(policy):
            raise TypeError(f"policy: expected a function of observations, not {policy!r}")
        self.pool.append(policy)

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        if seed is not None:
            self._random = np.random.default_rng(seed)
        self._seen, info = self.envs.reset(seed=seed, options=options)
        mask = (options or {}).get("reset_mask")
        every = np.ones(self.num_worlds, bool)
        self._draw(every if mask is None else every & np.any(np.reshape(mask, (self.num_worlds, -1)), axis=1))
        return self._rows(self._seen, self._learns), self._info(info)

    def step(self, actions: Any) -> tuple[Any, np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        if self._seen is None:
            raise MatchError("the episode is over, or has not begun; expected a reset before the next step")
        everybody = self._no_actions(len(self._learns))
        _put(everybody, self._learns, actions, "actions")
        for number in np.unique(self.drawn):
            rows = ~self._learns & (self.drawn[self._world] == number)
            if rows.any():
                _put(everybody, rows, self._answer(self.pool[number], rows), f"policy {number} of the pool")
        self._seen, rewards, terminations, truncations, info = self.envs.step(everybody)
        over = (terminations | truncations).reshape(self.num_worlds, -1)[:, 0]
        self._draw(over)
        mine = self._learns
        return self._rows(self._seen, mine), rewards[mine], terminations[mine], truncations[mine], self._info(info)

    def state(self) -> np.ndarray:
        """The true state of each world, as in :meth:`naoisis.VectorEnv.state`."""
        return self.envs.state()

    def action_masks(self) -> np.ndarray:
        """For each row and each choice, whether it has an effect now, as in :meth:`naoisis.VectorEnv.action_masks`."""
        masks: np.ndarray = self.envs.action_masks()[self._learns]
        return masks

    def render(self) -> tuple[np.ndarray, ...] | None:
        """Pictures of the fields of the first worlds."""
        return self.envs.render()

    def _answer(self, policy: Policy, rows: np.ndarray) -> Any:
        observations = self._rows(self._seen, rows)
        if not isinstance(policy, LearnedPolicy):
            return policy(observations)
        robots = np.flatnonzero(rows)
        actions, states = policy.act(observations, [self._states[robot] for robot in robots])
        for robot, state in zip(robots, states):
            self._states[robot] = state
        return actions

    def _draw(self, worlds: np.ndarray) -> None:
        self.drawn[worlds] = self._random.integers(len(self.pool), size=int(worlds.sum()))
        for robot in np.flatnonzero(worlds[self._world]):
            self._states[robot] = []

    def _stand(self, observations: Any) -> np.ndarray:
        return self._no_actions(len(observations["body"] if isinstance(observations, dict) else observations))

    def _no_actions(self, rows: int) -> np.ndarray:
        actions: Any = create_empty_array(self.single_action_space, rows, np.zeros)
        return np.asarray(actions)

    def _rows(self, observations: Any, rows: np.ndarray) -> Any:
        if isinstance(observations, dict):
            return {name: array[rows] for name, array in observations.items()}
        return observations[rows]

    def _info(self, info: dict[str, Any]) -> dict[str, Any]:
        mine = self._learns
        return {name: self._info(value) if isinstance(value, dict) else value[mine] for name, value in info.items()}

    def close_extras(self, **options: Any) -> None:
        # There are none where the arguments were wrong.
        if "envs" in vars(self):
            self.envs.close()


def _put(everybody: np.ndarray, rows: np.ndarray, actions: Any, name: str) -> None:
    """Writes the actions of some rows of robots. Refuses other shapes, and numbers that are not whole where choices are expected."""
    array, shape = np.asarray(actions), everybody[rows].shape
    if array.size != int(np.prod(shape)):
        raise ValueError(f"{name}: the shape is {array.shape}; expected {shape}")
    if everybody.dtype.kind in "iu" and array.dtype.kind == "f" and not np.equal(array, np.floor(array)).all():
        raise ValueError(f"{name}: there is a number that is not whole; expected choices")
    everybody[rows] = array.reshape(shape)
