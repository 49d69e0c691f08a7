"""Worlds for learning, used by the environments of all libraries."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, TypedDict

import numpy as np
from gymnasium import spaces

from naoisis import _naoisis
from naoisis._arguments import Scenario, control_of, count_of, match_of, seed_of
from naoisis._names import suggesting_tasks
from naoisis._options import (
    changes_of,
    check_fields,
    check_memory,
    draws_of,
    extras_of,
    opponents_of,
    robots_of,
    weights_of,
    words_of,
)
from naoisis._rewards import BatchReward, Steps, read_only

if TYPE_CHECKING:
    from typing_extensions import Unpack

AUTO_RESETS = ("next_step", "same_step", "disabled")

Reward = Callable[[Mapping[str, Any], str], float]
"""A reward of one's own: of what is true now, as :meth:`naoisis.Match.truth` has it, and the robot's name."""


class CommonOptions(TypedDict, total=False):
    """The options of worlds in all environments, documented in :class:`naoisis.MatchEnv`."""

    action: str
    reward: Mapping[str, float] | Reward | BatchReward | None
    cycles_per_step: int | None
    set: Mapping[str, Any] | None
    realism: str | Sequence[str] | None
    draws: Mapping[str, tuple[float, float] | list[Any] | range] | None
    extras: Sequence[str]
    observed_robots: tuple[int, int] | None
    says: int
    statistics: bool
    camera: str | None
    image_size: tuple[int, int]


class WorldOptions(CommonOptions, total=False):
    """All options, including those that some environments have as arguments."""

    control: str | Iterable[str] | None
    opponents: str | Sequence[str] | None
    observation: str


class Worlds:
    """Worlds and the arrays that they fill. Each row is an agent; the agents of a world are neighbours."""

    @suggesting_tasks
    def __init__(
        self,
        scenario: Scenario,
        *,
        worlds: int = 1,
        auto_reset: str = "disabled",
        threads: int | None = 1,
        solo: bool = False,
        **options: Unpack[WorldOptions],
    ):
        unknown = [name for name in options if name not in WorldOptions.__annotations__]
        if unknown:
            # In the words of Python, for which libraries look.
            raise TypeError(
                f"got an unexpected keyword argument {unknown[0]!r}; expected one of "
                f"{', '.join(WorldOptions.__annotations__)}"
            )
        self._arguments = {
            "scenario": scenario,
            "worlds": worlds,
            "auto_reset": auto_reset,
            "threads": threads,
            "solo": solo,
            **options,
        }
        controlled = options.get("control")
        control = None if controlled is None else control_of(controlled)
        observation, action = options.get("observation", "perception"), options.get("action", "continuous")
        levels = words_of(options.get("realism"), "realism", "a level of realism")
        made = match_of(scenario, set=options.get("set"), realism=levels[0] if levels else None)
        check_fields(options.get("set"), "set")
        side, pool = opponents_of(options.get("opponents"), control)
        if pool:
            made[side] = pool[0]
        self._levels, self._pool = levels, pool
        draws = draws_of(options.get("draws"))
        self._drawn = [field for field, *_ in draws]
        given = {"realism": levels, "teams": pool}
        for field in self._drawn:
            if given.get(field.split(".")[0]):
                raise ValueError(f"draws: {field} is an option, too; expected it in one of the two only")
            if field in (options.get("set") or ()):
                raise ValueError(f"draws: {field} is set, too; expected it in one of the two only")
        # Fields that settings of the environment or of a reset can change, so that infos do not tell them.
        self._set = list(options.get("set") or ())
        reward = options.get("reward")
        self.batch_reward = reward if isinstance(reward, BatchReward) else None
        self.own_reward = reward if callable(reward) else None
        cycles = options.get("cycles_per_step")
        size = options.get("image_size", (48, 64))
        if not isinstance(size, Sequence) or len(size) != 2:
            raise TypeError(f"image_size: expected height and width, not {size!r}")
        height, width = size
        camera = options.get("camera")
        for name, word in (("observation", observation), ("action", action), ("camera", camera)):
            if not isinstance(word, str) and not (name == "camera" and word is None):
                raise TypeError(f"{name}: expected a text, not {word!r}")
        count = count_of(worlds, "num_envs", most=1_000_000)
        check_memory(count)
        self.inner = _naoisis.Environments(
            made,
            {
                "control": control,
                "others": [(side, team) for team in pool[1:]],
                "solo": solo,
                "observation": observation,
                "camera": camera,
                "image_size": [count_of(height, "image_size", most=4096), count_of(width, "image_size", most=4096)],
                "action": action,
                "cycles_per_step": None if cycles is None else count_of(cycles, "cycles_per_step"),
                "reward": None if callable(reward) or isinstance(reward, BatchReward) else weights_of(reward),
                "own_reward": self.own_reward is not None,
                "realisms": levels[1:],
                "draws": draws,
                "extras": extras_of(options.get("extras", ()), options.get("says", 0)),
                "observed_robots": robots_of(options.get("observed_robots")),
                "statistics": bool(options.get("statistics", False)),
                "worlds": count,
                "auto_reset": auto_reset,
                "threads": os.cpu_count() or 1 if threads is None else count_of(threads, "threads", most=1024),
            },
        )
        self.observation, self.action = observation, action
        # As in the layout of a policy.
        extras = extras_of(options.get("extras", ()), options.get("says", 0))
        self.extras = {name: value for name, value in extras.items() if value}
        self.agents = self.inner.control
        self.worlds = int(worlds)
        self.rows = self.worlds * len(self.agents)
        self._changes: list[dict[str, Any] | None] = [None] * self.worlds
        self._states = np.zeros((0, 0), np.float32)
        self.observation_entries = self.inner.entries()
        self.observation_names = [name for name, *_ in self.observation_entries]
        self.state_names = [name for name, *_ in self.inner.state_entries()]
        # The first reset makes all of them.
        check_memory(self.worlds, sum(name.endswith(".plays") for name in self.state_names))
        self.action_names = self.inner.action_names()
        self.step_s = self.inner.cycles_per_step * self.inner.cycle_s
        low, high = (np.array([entry[side] for entry in self.observation_entries], np.float32) for side in (1, 2))
        self.image_shape = (height, width, 3) if observation == "image" else None
        numbers = spaces.Box(low, high, dtype=np.float32)
        self.observation_space: spaces.Space[Any] = numbers
        if self.image_shape:
            self.observation_space = spaces.Dict(
                {"body": numbers, "image": spaces.Box(0, 255, self.image_shape, np.uint8)}
            )
        counts = [len(names) for names in self.action_names]
        self.action_space: spaces.Space[Any]
        if action == "continuous":
            self.action_space = spaces.Box(-1.0, 1.0, (counts[0],), np.float32)
        elif action == "discrete":
            self.action_space = spaces.Discrete(counts[0])
        else:
            self.action_space = spaces.MultiDiscrete(counts)
        self.numbers_of_action = counts[0] if action == "continuous" else len(counts)
        self._no_images = np.empty((0, 0), np.uint8)
        self._no_finals = self._new_finals(0, 0)
        self.let_go_of_finals()
        filled = {name: array for name, array in self.arrays().items() if not name.startswith("final_")}
        self._right_arrays = {name: (array.dtype, array.shape) for name, array in filled.items()}

    def arrays(self, with_final: bool = False) -> dict[str, np.ndarray]:
        """New arrays for a step to fill, which writes all of their numbers. Those at the end of episodes are new only after :meth:`let_go_of_finals`."""
        rows = self.rows
        finals = self._finals if with_final else self._no_finals
        if self.batch_reward is not None:
            finals = {**finals, "final_states": np.empty((self.worlds, len(self.state_names)), np.float32)}
        return {
            "observations": np.empty((rows, len(self.observation_names)), np.float32),
            "images": np.empty((rows, *self.image_shape), np.uint8) if self.image_shape else self._no_images,
            "rewards": np.empty(rows, np.float32),
            "terminations": np.empty(rows, np.bool_),
            "truncations": np.empty(rows, np.bool_),
            "successes": np.empty(rows, np.bool_),
            **finals,
        }

    def let_go_of_finals(self) -> None:
        """Leaves the arrays at the end of episodes to the caller: the next step gets others."""
        self._finals = self._new_finals(self.rows, self.worlds)

    def _new_finals(self, rows: int, worlds: int) -> dict[str, np.ndarray]:
        return {
            "final_observations": np.empty((rows, len(self.observation_names)), np.float32),
            "final_images": np.empty((rows if self.image_shape else 0, *(self.image_shape or (0,))), np.uint8),
            "final_states": np.empty((worlds, len(self.state_names)), np.float32),
        }

    def check_arrays(self, arrays: Mapping[str, Any]) -> None:
        """Checks that the arrays of a caller are of the type, shape and order that a step fills."""
        for name, (dtype, shape) in self._right_arrays.items():
            array = arrays[name]
            if not isinstance(array, np.ndarray):
                raise TypeError(f"{name}: expected an array of NumPy, not {type(array).__name__}")
            if array.dtype != dtype:
                raise TypeError(f"{name}: {array.dtype}; expected {dtype}")
            if array.shape != shape:
                raise ValueError(f"{name}: an array of shape {array.shape}; expected {shape}")
            if not array.flags.c_contiguous:
                raise ValueError(f"{name}: expected a contiguous array, row by row, as of np.ascontiguousarray")

    def actions(self, actions: Any) -> np.ndarray:
        """The actions in the form of the compiled module."""
        shape = (self.rows, self.numbers_of_action)
        try:
            given = np.asarray(actions)
            if np.iscomplexobj(given):
                raise TypeError("they are complex")
            array = np.ascontiguousarray(given, dtype=np.float32)
        except (TypeError, ValueError) as error:
            raise TypeError(
                f"actions: expected numbers, {self.rows} rows of {self.numbers_of_action}: {error}"
            ) from None
        # A single robot, and a single choice, need no axis of their own.
        needed = tuple(length for length in shape if length > 1)
        if not given.size or tuple(length for length in given.shape if length > 1) != needed:
            raise ValueError(f"actions: an array of shape {array.shape}; expected {shape}")
        return array

    def observations(self, arrays: Mapping[str, np.ndarray], prefix: str = "") -> Any:
        """The observations of all agents, row by row, as in their space."""
        if self.image_shape:
            return {"body": arrays[f"{prefix}observations"], "image": arrays[f"{prefix}images"]}
        return arrays[f"{prefix}observations"]

    def row(self, observations: Any, row: int) -> Any:
        """The observation of one agent."""
        if self.image_shape:
            return {name: array[row] for name, array in observations.items()}
        return observations[row]

    def reset(
        self,
        seed: int | None,
        arrays: dict[str, np.ndarray],
        options: Mapping[str, Any] | None = None,
        mask: np.ndarray | None = None,
    ) -> None:
        """Starts episodes, with the changes of :func:`changes_of`."""
        changes = changes_of(options or {})
        match_seed = seed_of((options or {}).get("match_seed"), "options: match_seed")
        self.inner.reset(seed_of(seed), match_seed, mask, changes, arrays)
        self._keep_states()
        for world in range(self.worlds) if mask is None else np.flatnonzero(mask):
            self._changes[world] = changes

    def __getstate__(self) -> dict[str, Any]:
        return {"arguments": self._arguments, "changes": self._changes, "saved": self.inner.save()}

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Creates the same worlds, in the middle of the same episodes."""
        self.__init__(**state["arguments"])  # type: ignore[misc]
        self._changes = list(state["changes"])
        changed: dict[int, tuple[list[int], dict[str, Any]]] = {}
        for world, changes in enumerate(self._changes):
            if changes is not None:
                changed.setdefault(id(changes), ([], changes))[0].append(world)
        self.inner.restore(state["saved"], list(changed.values()))
        self._keep_states()

    def step(self, actions: Any, arrays: dict[str, np.ndarray]) -> bool:
        """Plays a step, and computes a custom reward if there is one. Returns whether an episode is over."""
        acted = self.actions(actions)
        is_any_over = self.inner.step(acted, arrays)
        if self.batch_reward is not None:
            shape = (self.worlds, len(self.agents))
            of_worlds = {name: arrays[name].reshape(shape)[:, 0] for name in ("terminations", "truncations")}
            steps = Steps(
                before=read_only(self._states),
                after=read_only(arrays["final_states"]),
                names=self.state_names,
                agents=self.agents,
                actions=read_only(acted.reshape(*shape, -1)),
                terminated=read_only(of_worlds["terminations"]),
                truncated=read_only(of_worlds["truncations"]),
                success=read_only(arrays["successes"].reshape(shape)),
                seconds=self.step_s,
            )
            # The worlds have been stepped, also if the function fails.
            self._keep_states()
            arrays["rewards"][...] = self.batch_reward.of(steps).reshape(-1)
        if self.own_reward is not None:
            truths = [self.inner.truth(world) for world in range(self.worlds)]
            rewards = [self._reward_of(truth, robot) for truth in truths for robot in self.agents]
            arrays["rewards"][...] = np.asarray(rewards, np.float32)
        return is_any_over

    def _keep_states(self) -> None:
        """Keeps the states before the next step, if a reward needs them."""
        if self.batch_reward is not None:
            self._states = self.inner.state()

    def origin(self, world: int) -> dict[str, Any]:
        """What the episode of a world began from, for infos: its seed, and what was drawn for it."""
        return self._origin_of(world, self.inner.origin(world))

    def _origin_of(self, world: int, origin: Mapping[str, Any]) -> dict[str, Any]:
        # Gymnasium's vector environments keep whole numbers of Python as int64, which is too small.
        info: dict[str, Any] = {"match_seed": np.uint64(origin["seed"])}
        changes = self._changes[world] or {}
        if changes.get("snapshot") is not None:
            return info
        level, team = divmod(origin["scenario"], max(1, len(self._pool)))
        changed = changes.get("draws")
        drawn = self._drawn if changed is None else [field for field, *_ in changed]
        set_here = {str(field).split(".")[0] for field in (*self._set, *(changes.get("set") or ()), *drawn)}
        if self._pool and "teams" not in set_here:
            info["opponents"] = self._pool[team]
        if self._levels and "realism" not in set_here:
            info["realism"] = self._levels[level]
        if drawn:
            info["drawn"] = dict(zip(drawn, origin["drawn"]))
        return info

    def ended(self, world: int, agent: int = 0) -> dict[str, Any]:
        """What is said of an episode that ended in the last step, to one of its agents: its origin, and its statistics if they are counted."""
        ended = self.inner.ended(world)
        if ended is None:
            return {}
        origin, counts = ended
        info = self._origin_of(world, origin)
        if counts:
            side = self.agents[agent].startswith("pink")
            info["statistics"] = {
                **{name: teams[side] for name, *teams in counts},
                **{f"opponents_{name}": teams[not side] for name, *teams in counts},
            }
        return info

    def action_masks(self) -> np.ndarray:
        """For each row and each choice, list by list, whether the choice has an effect now."""
        masks = self.inner.action_masks()
        if not masks.size:
            raise ValueError(f"action_masks: an action {self.action!r} has no choices; expected another kind of action")
        return masks.reshape(self.rows, -1)

    def _reward_of(self, truth: Mapping[str, Any], robot: str) -> float:
        """The custom reward of a robot."""
        value = self.own_reward(truth, robot) if self.own_reward else None
        if not isinstance(value, (float, int, np.number, np.bool_)):
            raise TypeError(f"reward: the function returned {value!r} for {robot}; expected a number")
        if not np.isfinite(value):
            raise ValueError(f"reward: the function returned {value!r} for {robot}; expected a finite number")
        return float(value)

    def picture(self, size: tuple[int, int] = (540, 960), world: int = 0) -> np.ndarray:
        """A picture of the field of a world."""
        height, width = size
        return self.inner.picture(world, width, height)


def agent_name(robot: str) -> str:
    """The name of a robot as an agent: ``blue_1``."""
    return f"{robot[:4]}_{robot[4:]}"
