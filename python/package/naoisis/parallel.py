"""Environments of PettingZoo: one or both teams learn. Needs ``pip install naoisis[pettingzoo]``."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from gymnasium import spaces
from pettingzoo import ParallelEnv

from naoisis._arguments import Scenario
from naoisis._view import View, modes_here
from naoisis._worlds import Worlds, agent_name
from naoisis.errors import MatchError

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from naoisis._worlds import CommonOptions

__all__ = ["MatchParallelEnv"]

RENDER_MODES = ("rgb_array", "human")


class MatchParallelEnv(ParallelEnv):
    """The robots of a match, or of a named task, as agents ``blue_1``, ``blue_2`` and so on.

    All agents stay to the end: a penalised one has ``body.penalised`` in its observation, and its actions have no effect.
    The arguments are those of :func:`naoisis.parallel_env`.

    Attributes:
        observation_names: The names of the numbers of an observation.
        action_names: The names of the numbers of an action, or of the choices, one list per choice.
        state_space: The space of :meth:`state`.
    """

    def __init__(self, worlds: Worlds, view: View):
        self._worlds, self._view, self.render_mode = worlds, view, view.mode
        self.metadata = {
            "name": "naoisis",
            "render_modes": modes_here(),
            "render_fps": round(1 / worlds.step_s),
            "is_parallelizable": True,
        }
        self.possible_agents = [agent_name(robot) for robot in worlds.agents]
        self.agents: list[str] = []
        # The same objects each time.
        self.observation_spaces = {agent: worlds.observation_space for agent in self.possible_agents}
        self.action_spaces = {agent: worlds.action_space for agent in self.possible_agents}
        self.observation_names, self.action_names = worlds.observation_names, worlds.action_names
        low, high = (np.array([entry[side] for entry in worlds.inner.state_entries()], np.float32) for side in (1, 2))
        self.state_space = spaces.Box(low, high, dtype=np.float32)
        self._has_seed = False

    def observation_space(self, agent: str) -> Any:
        return self.observation_spaces[agent]

    def action_space(self, agent: str) -> Any:
        return self.action_spaces[agent]

    def reset(
        self,
        seed: int | None = None,
        options: dict[str, Any] | None = None,
    ) -> tuple[dict[str, Any], dict[str, dict[str, Any]]]:
        """Starts an episode. Uses the options of :class:`naoisis.MatchEnv`, and ignores others, such as those of wrappers."""
        if options is not None and not isinstance(options, Mapping):
            raise TypeError(f"options: expected a dictionary, not {options!r}")
        if seed is None and not self._has_seed:
            seed = int(np.random.default_rng().integers(2**32))
        arrays = self._worlds.arrays()
        self._worlds.reset(seed, arrays, options)
        self._has_seed = True
        self._view.show(self._worlds)
        self.agents = list(self.possible_agents)
        return self._each(self._worlds.observations(arrays)), {agent: self._worlds.origin(0) for agent in self.agents}

    def step(
        self,
        actions: Mapping[str, Any],
    ) -> tuple[dict[str, Any], dict[str, float], dict[str, bool], dict[str, bool], dict[str, dict[str, Any]]]:
        if not self.agents:
            raise MatchError("the episode is over, or has not begun; expected a reset before the next step")
        if not isinstance(actions, Mapping):
            raise TypeError(f"actions: expected a dictionary of agents and their actions, not {actions!r}")
        foreign = [agent for agent in actions if agent not in self.agents]
        if foreign:
            raise ValueError(f"actions: there is no agent {foreign[0]!r}; expected {', '.join(self.agents)}")
        missing = [agent for agent in self.agents if agent not in actions]
        if missing:
            raise ValueError(f"actions: missing for {', '.join(missing)}; expected one for each agent")
        arrays = self._worlds.arrays()
        rows = [np.ravel(actions[agent]) for agent in self.agents]
        self._worlds.step(rows, arrays)
        self._view.show(self._worlds)
        observations, agents = self._each(self._worlds.observations(arrays)), self.agents
        rewards = dict(zip(agents, map(float, arrays["rewards"])))
        terminations = dict(zip(agents, map(bool, arrays["terminations"])))
        truncations = dict(zip(agents, map(bool, arrays["truncations"])))
        is_over = terminations[agents[0]] or truncations[agents[0]]
        successes = map(bool, arrays["successes"])
        infos: dict[str, dict[str, Any]] = {
            agent: {"success": success, **self._worlds.ended(0, number)} if is_over else {}
            for number, (agent, success) in enumerate(zip(agents, successes))
        }
        if is_over:
            self.agents = []
        return observations, rewards, terminations, truncations, infos

    def _each(self, observations: Any) -> dict[str, Any]:
        return {agent: self._worlds.row(observations, row) for row, agent in enumerate(self.possible_agents)}

    def state(self) -> np.ndarray:
        """The true state as an array, for critics, in the frame of the blue team; its names are ``state_names``."""
        state: np.ndarray = self._worlds.inner.state()[0]
        return state

    def action_masks(self) -> dict[str, np.ndarray]:
        """For each agent and each choice, list by list, whether it has an effect now: see :meth:`naoisis.MatchEnv.action_masks`."""
        return dict(zip(self.possible_agents, self._worlds.action_masks()))

    @property
    def state_names(self) -> list[str]:
        """The names of the numbers of :meth:`state`."""
        return list(self._worlds.state_names)

    def truth(self) -> dict[str, Any]:
        """The current truth: see :meth:`naoisis.Match.truth`. With the observation ``"truth"``, controlled robots perceive nothing."""
        return self._worlds.inner.truth(0)

    def snapshot(self) -> bytes:
        """A snapshot of the match, to start episodes from: ``reset(options={"snapshot": ...})``. Robots see in the first observation what
        they saw in the snapshot: nothing, if the truth is observed here. A robot without a belief in it begins with its true pose, if beliefs are
        observed there, as at the start of a match."""
        return self._worlds.inner.snapshot(0)

    def render(self) -> np.ndarray | None:
        return self._worlds.picture() if self.render_mode == "rgb_array" else None

    def close(self) -> None:
        self._view.close()


def parallel_env(
    scenario: Scenario = "match3v3",
    control: str | Iterable[str] | None = None,
    opponents: str | Sequence[str] | None = None,
    observation: str = "perception",
    *,
    render_mode: str | None = None,
    **options: Unpack[CommonOptions],
) -> MatchParallelEnv:
    """Creates the environment: see :func:`naoisis.parallel_env`."""
    view = View(render_mode, RENDER_MODES)
    worlds = Worlds(scenario, control=control, opponents=opponents, observation=observation, **options)
    return MatchParallelEnv(worlds, view)
