"""Many worlds as one environment of TorchRL, with teams as groups of agents. Needs ``pip install naoisis[torchrl]``.

>>> from naoisis.torchrl import MatchEnv
>>> env = MatchEnv("match3v3", num_envs=64, control="blue", opponents="roles", observation="belief")
>>> data = env.rollout(100)
>>> data["blue", "observation"].shape       # worlds, steps, robots, numbers
torch.Size([64, 100, 3, 58])
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import torch
from gymnasium import spaces
from tensordict import TensorDict, TensorDictBase
from torchrl.data import Binary, Bounded, Categorical, Composite, MultiCategorical, Unbounded
from torchrl.envs import EnvBase
from torchrl.envs.utils import MarlGroupMapType, check_marl_grouping

from naoisis._arguments import Scenario, seed_of
from naoisis._options import check_options
from naoisis._worlds import Worlds, agent_name

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from naoisis._worlds import CommonOptions

__all__ = ["MatchEnv"]

Flags = np.ndarray
"""A flag for each world."""


class MatchEnv(EnvBase):
    """Many worlds that are stepped together, as a batch: the robots of a match, or of a task, as agents ``blue_1`` and so on, in groups.

    A tensordict has for each group, by default the teams ``"blue"`` and ``"pink"``, the entries ``observation``, ``action``, ``reward`` and
    ``info``, of the shape (worlds, agents of the group, numbers); and ``state``, the true state of each world for critics, ``done``,
    ``terminated`` and ``truncated`` for all agents of a world. Images are in ``pixels`` beside ``observation``. Choices are numbers, not one-hot.
    ``info`` has ``success``, which an ended episode may be for the agent's team.

    Args:
        scenario: A task's name (:func:`naoisis.tasks`), or a scenario as of :class:`naoisis.Match`.
        num_envs: The number of worlds.
        control: A team, ``"blue"``, or robots, such as ``["blue1", "pink2"]`` [default: all of the task's].
        opponents: The name of the other team, if the scenario has teams; from a list of names one is drawn for each episode.
        observation, action, reward, cycles_per_step, set, realism, camera, image_size: As of :class:`naoisis.MatchEnv`.
        threads: The number of threads [default: one per core].
        device: The device of the tensors. Worlds are stepped by the processor.
        seed: The seed of the first world, as of ``set_seed``.
        group_map: The agents of each group, or a ``MarlGroupMapType`` [default: the teams].

    ``reset(options=...)`` has the options of :class:`naoisis.MatchEnv`.

    Attributes:
        agent_names: The names of all agents of a world.
        group_map: The agents of each group.
        observation_names, action_names, state_names: The names of the numbers, as of :class:`naoisis.MatchEnv`.
    """

    def __init__(
        self,
        scenario: Scenario = "match3v3",
        num_envs: int = 1,
        *,
        control: str | Iterable[str] | None = None,
        opponents: str | Sequence[str] | None = None,
        observation: str = "perception",
        threads: int | None = None,
        device: torch.device | str | None = None,
        seed: int | None = None,
        group_map: Mapping[str, list[str]] | MarlGroupMapType | None = None,
        **options: Unpack[CommonOptions],
    ):
        worlds = Worlds(
            scenario,
            worlds=num_envs,
            threads=threads,
            control=control,
            opponents=opponents,
            observation=observation,
            **options,
        )
        super().__init__(device=device, batch_size=torch.Size([worlds.worlds]))
        self._worlds = worlds
        self.agent_names = [agent_name(robot) for robot in worlds.agents]
        self.group_map = _groups(group_map, self.agent_names)
        self._members = {
            group: [self.agent_names.index(agent) for agent in agents] for group, agents in self.group_map.items()
        }
        self.observation_names, self.action_names = worlds.observation_names, worlds.action_names
        self.state_names = [name for name, *_ in worlds.inner.state_entries()]
        self._arrays = {name: np.zeros_like(array) for name, array in worlds.arrays().items()}
        self._state = np.zeros((worlds.worlds, len(self.state_names)), np.float32)
        # Whether the episode of a world is over in the simulator, and to the one who steps it.
        self._is_over = np.zeros(worlds.worlds, np.bool_)
        self._is_done = np.zeros(worlds.worlds, np.bool_)
        self._first_seed, self._has_begun = seed_of(seed), False
        self._make_specs()

    def _make_specs(self) -> None:
        worlds, device, batch = self._worlds, self.device, self.batch_size
        seen: Any = worlds.observation_space
        if worlds.image_shape:
            seen = seen["body"]
        observations, actions, rewards = (Composite(shape=batch, device=device) for _ in range(3))
        for group, members in self._members.items():
            shape = torch.Size([*batch, len(members)])
            of_group = {
                "observation": _box(seen.low, seen.high, shape, device),
                "info": Composite(success=Binary(1, shape=(*shape, 1), device=device, dtype=torch.bool), shape=shape),
            }
            if worlds.image_shape:
                image = (*shape, *worlds.image_shape)
                of_group["pixels"] = Bounded(0, 255, shape=image, device=device, dtype=torch.uint8)
            observations[group] = Composite(of_group, shape=shape, device=device)
            actions[group] = Composite(
                action=_action_spec(worlds.action_space, shape, device), shape=shape, device=device
            )
            reward = Unbounded(shape=(*shape, 1), device=device, dtype=torch.float32)
            rewards[group] = Composite(reward=reward, shape=shape, device=device)
        entries = worlds.inner.state_entries()
        low, high = (np.array([entry[side] for entry in entries], np.float32) for side in (1, 2))
        observations["state"] = _box(low, high, batch, device)
        self.observation_spec, self.action_spec, self.reward_spec = observations, actions, rewards
        flag = Categorical(2, shape=(*batch, 1), device=device, dtype=torch.bool)
        ends = {name: flag.clone() for name in ("done", "terminated", "truncated")}
        self.done_spec = Composite(ends, shape=batch, device=device)

    def _set_seed(self, seed: int | None) -> None:
        self._first_seed, self._has_begun = seed_of(seed), False

    def _reset(self, tensordict: TensorDictBase | None = None, **kwargs: Any) -> TensorDictBase:
        options = kwargs.get("options")
        check_options(options)
        mask = None if tensordict is None else tensordict.get("_reset", None)
        begins = np.ones(self._worlds.worlds, np.bool_) if mask is None else _flags(mask)
        if begins.any():
            seed = None
            if begins.all() and not self._has_begun:
                # By the random numbers of PyTorch, so that its seed repeats everything.
                seed = int(torch.randint(2**31, ()).item()) if self._first_seed is None else self._first_seed
                self._has_begun = True
            self._worlds.reset(seed, self._arrays, options, None if begins.all() else begins)
        for name in ("rewards", "terminations", "truncations", "successes"):
            self._of_worlds(self._arrays[name])[begins] = 0
        self._is_over[begins] = self._is_done[begins] = False
        self._state[begins] = self._worlds.inner.state()[begins]
        return self._tensors(with_rewards=False)

    def _step(self, tensordict: TensorDictBase) -> TensorDictBase:
        wanted = tensordict.get("_step", None)
        rests = np.zeros(self._worlds.worlds, np.bool_) if wanted is None else ~_flags(wanted)
        if (rests & ~self._is_done).any():
            world = int(np.flatnonzero(rests & ~self._is_done)[0])
            raise ValueError(
                f"_step: the episode of world {world} is not over; expected worlds to rest after their episodes only"
            )
        of_agents = {name: array for name, array in self._arrays.items() if not name.startswith("final_")}
        shown = {name: self._of_worlds(array)[rests].copy() for name, array in of_agents.items()}
        if (rests & self._is_over).any():
            # All worlds are stepped together, so those that rest play an episode that nobody sees.
            self._worlds.reset(None, self._arrays, None, rests & self._is_over)
        self._worlds.step(self._actions(tensordict, rests), self._arrays)
        self._is_over = self._of_worlds(self._arrays["terminations"] | self._arrays["truncations"])[:, 0].copy()
        self._is_done = self._is_over | rests
        for name, array in of_agents.items():
            self._of_worlds(array)[rests] = 0 if name == "rewards" else shown[name]
        self._state[~rests] = self._worlds.inner.state()[~rests]
        return self._tensors(with_rewards=True)

    def _actions(self, tensordict: TensorDictBase, rests: Flags) -> np.ndarray:
        """The actions of all agents, row by row."""
        worlds = self._worlds
        actions = np.zeros((worlds.worlds, len(self.agent_names), worlds.numbers_of_action), np.float32)
        for group, members in self._members.items():
            chosen = tensordict.get((group, "action")).detach().cpu().numpy()
            actions[:, members] = chosen.reshape(worlds.worlds, len(members), -1)
        actions[rests] = 0.0
        return actions.reshape(worlds.rows, -1)

    def _of_worlds(self, array: np.ndarray) -> np.ndarray:
        """A view of an array of rows, with an axis for the worlds and one for their agents."""
        agents = len(self.agent_names) if array.size else 0
        return array.reshape(self._worlds.worlds, agents, *array.shape[1:])

    def _tensors(self, with_rewards: bool) -> TensorDictBase:
        """What there is to see, copied from the arrays of the worlds."""
        of_agents = {
            name: self._of_worlds(array) for name, array in self._arrays.items() if not name.startswith("final_")
        }

        def tensor(array: np.ndarray) -> torch.Tensor:
            return torch.from_numpy(np.array(array)).to(self.device)

        source: dict[str, Any] = {"state": tensor(self._state)}
        for group, members in self._members.items():
            shape = torch.Size([*self.batch_size, len(members)])
            success = tensor(of_agents["successes"][:, members, None])
            entries: dict[str, Any] = {
                "observation": tensor(of_agents["observations"][:, members]),
                "info": TensorDict({"success": success}, batch_size=shape, device=self.device),
            }
            if self._worlds.image_shape:
                entries["pixels"] = tensor(of_agents["images"][:, members])
            if with_rewards:
                entries["reward"] = tensor(of_agents["rewards"][:, members, None])
            source[group] = TensorDict(entries, batch_size=shape, device=self.device)
        terminated, truncated = (of_agents[name][:, :1] for name in ("terminations", "truncations"))
        source |= {
            "done": tensor(terminated | truncated),
            "terminated": tensor(terminated),
            "truncated": tensor(truncated),
        }
        return TensorDict(source, batch_size=self.batch_size, device=self.device)

    def truth(self, world: int = 0) -> dict[str, Any]:
        """The current truth of a world: see :meth:`naoisis.Match.truth`. With the observation ``"truth"``, controlled robots perceive nothing."""
        return self._worlds.inner.truth(world)

    def __repr__(self) -> str:
        agents = ", ".join(self.agent_names)
        return f"MatchEnv(agents={agents}, batch_size={list(self.batch_size)}, device={self.device})"

    def render(self, world: int = 0, **_: Any) -> np.ndarray:
        """A picture of the field of a world, for ``PixelRenderTransform`` and others."""
        return self._worlds.picture((270, 480), world)


def _groups(groups: Mapping[str, list[str]] | MarlGroupMapType | None, agents: list[str]) -> dict[str, list[str]]:
    if groups is None:
        teams = dict.fromkeys(agent.split("_")[0] for agent in agents)
        groups = {team: [agent for agent in agents if agent.startswith(team)] for team in teams}
    made = groups.get_group_map(agents) if isinstance(groups, MarlGroupMapType) else dict(groups)
    check_marl_grouping(made, agents)
    return made


def _box(low: np.ndarray, high: np.ndarray, shape: torch.Size, device: Any) -> Bounded:
    """What the numbers of each agent, or of each world, can be."""
    ends = [torch.from_numpy(end).to(device).expand(*shape, len(end)).clone() for end in (low, high)]
    return Bounded(*ends, shape=(*shape, len(low)), device=device, dtype=torch.float32)


def _action_spec(space: spaces.Space[Any], shape: torch.Size, device: Any) -> Any:
    if isinstance(space, spaces.Discrete):
        return Categorical(int(space.n), shape=shape, device=device)
    if isinstance(space, spaces.MultiDiscrete):
        counts = torch.from_numpy(np.asarray(space.nvec))
        return MultiCategorical(counts, shape=(*shape, len(counts)), device=device)
    assert isinstance(space, spaces.Box)
    return _box(space.low, space.high, shape, device)


def _flags(tensor: torch.Tensor) -> Flags:
    """A flag for each world, of which all agents have the same."""
    array: np.ndarray = tensor.detach().cpu().numpy()
    return array.reshape(len(array), -1)[:, 0].astype(np.bool_)
