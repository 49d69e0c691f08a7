"""Worlds for learning, used by the environments of all libraries."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, TypedDict

import numpy as np
from gymnasium import spaces

from naoisis import _naoisis
from naoisis._arguments import Scenario, check_set, control_of, count_of, match_of, seed_of, word_of
from naoisis._names import suggesting_tasks

if TYPE_CHECKING:
    from typing_extensions import Unpack

AUTO_RESETS = ("next_step", "same_step", "disabled")

Reward = Callable[[Mapping[str, Any], str], float]
"""A reward of one's own: of what is true now, as :meth:`naoisis.Match.truth` has it, and the robot's name."""


class CommonOptions(TypedDict, total=False):
    """The options of worlds in all environments, documented in :class:`naoisis.MatchEnv`."""

    action: str
    reward: Mapping[str, float] | Reward | None
    cycles_per_step: int | None
    set: Mapping[str, Any] | None
    realism: str | None
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
        made = match_of(scenario, set=options.get("set"), realism=options.get("realism"))
        side, pool = _opponents(options.get("opponents"), control)
        if pool:
            made[side] = pool[0]
        reward = options.get("reward")
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
        _check_memory(count)
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
                "reward": None if callable(reward) else _weights(reward),
                "own_reward": callable(reward),
                "worlds": count,
                "auto_reset": auto_reset,
                "threads": os.cpu_count() or 1 if threads is None else count_of(threads, "threads", most=1024),
            },
        )
        self.observation, self.action = observation, action
        self.agents = self.inner.control
        self.worlds = int(worlds)
        self.rows = self.worlds * len(self.agents)
        self._changes: list[dict[str, Any] | None] = [None] * self.worlds
        self.observation_entries = self.inner.entries()
        self.observation_names = [name for name, *_ in self.observation_entries]
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
        filled = {name: array for name, array in self.arrays().items() if not name.startswith("final_")}
        self._right_arrays = {name: (array.dtype, array.shape) for name, array in filled.items()}

    def arrays(self, with_final: bool = False) -> dict[str, np.ndarray]:
        """New arrays for a step to fill."""
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
        self.inner.reset(seed_of(seed), mask, changes, arrays)
        for world in range(self.worlds) if mask is None else np.flatnonzero(mask):
            self._changes[world] = changes

    def __getstate__(self) -> dict[str, Any]:
        return {"arguments": self._arguments, "changes": self._changes, "saved": self.inner.save()}

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Makes the same worlds anew, in the middle of the same episodes."""
        self.__init__(**state["arguments"])  # type: ignore[misc]
        self._changes = list(state["changes"])
        changed: dict[int, tuple[list[int], dict[str, Any]]] = {}
        for world, changes in enumerate(self._changes):
            if changes is not None:
                changed.setdefault(id(changes), ([], changes))[0].append(world)
        self.inner.restore(state["saved"], list(changed.values()))

    def step(self, actions: Any, arrays: dict[str, np.ndarray]) -> None:
        """Plays a step, and computes a custom reward if there is one and no world has started its next episode."""
        self.inner.step(self.actions(actions), arrays)
        if self.own_reward is not None:
            truths = [self.inner.truth(world) for world in range(self.worlds)]
            rewards = [self._reward_of(truth, robot) for truth in truths for robot in self.agents]
            arrays["rewards"][...] = np.asarray(rewards, np.float32)

    def _reward_of(self, truth: Mapping[str, Any], robot: str) -> float:
        """The custom reward of a robot."""
        value = self.own_reward(truth, robot) if self.own_reward else None
        if not isinstance(value, (float, int, np.number, np.bool_)):
            raise TypeError(f"reward: the function returned {value!r} for {robot}; expected a number")
        return float(value)

    def picture(self, size: tuple[int, int] = (540, 960), world: int = 0) -> np.ndarray:
        """A picture of the field of a world."""
        height, width = size
        return self.inner.picture(world, width, height)


CHANGES = ("set", "situation", "snapshot")


def changes_of(options: Mapping[str, Any]) -> dict[str, Any] | None:
    """The changes of episodes by the options of a reset; None if there are none."""
    changes: dict[str, Any] = dict.fromkeys(CHANGES)
    for name in ("set", "situation"):
        value = options.get(name)
        if value is not None and not isinstance(value, Mapping):
            raise TypeError(f"options: {name}: expected a dictionary, not {value!r}")
        changes[name] = None if value is None else dict(value)
    check_set(changes["set"])
    snapshot = options.get("snapshot")
    if snapshot is not None:
        if not isinstance(snapshot, (bytes, bytearray)):
            raise TypeError(
                f"options: snapshot: expected the bytes of a match's snapshot, not {type(snapshot).__name__}"
            )
        if changes["set"] is not None or changes["situation"] is not None:
            raise ValueError("options: a snapshot cannot be changed; expected no `set` and no `situation` beside it")
        changes["snapshot"] = bytes(snapshot)
    return changes if any(value is not None for value in changes.values()) else None


def check_options(options: Mapping[str, Any] | None, *more: str) -> None:
    """Checks that a reset knows all of its options."""
    if options is not None and not isinstance(options, Mapping):
        raise TypeError(f"options: expected a dictionary, not {options!r}")
    for name in options or ():
        if name not in (*CHANGES, *more):
            raise ValueError(f"options: there is no {name!r}; expected {', '.join((*CHANGES, *more))}")


def _opponents(opponents: Any, control: list[str] | None) -> tuple[str, list[str]]:
    """The side of the opponents, and the names of the teams from which one is drawn for each episode."""
    side = "blue" if control and control[0].startswith("pink") else "pink"
    if opponents is None or isinstance(opponents, str):
        return side, [] if opponents is None else [opponents]
    if not isinstance(opponents, Sequence) or not opponents:
        raise TypeError(f"opponents: expected the name of a team, or a list of names, not {opponents!r}")
    for team in opponents:
        word_of(team, "opponents")
    return side, list(opponents)


def _weights(reward: Mapping[str, float] | None) -> dict[str, float] | None:
    if reward is None:
        return None
    if not isinstance(reward, Mapping):
        names = ", ".join(name for name, _ in _naoisis.Environments.rewards())
        raise TypeError(f"reward: expected a dictionary of {names} and their weights, not {reward!r}")
    weights = {}
    for name, weight in reward.items():
        try:
            weights[name] = float(weight)
        except (TypeError, ValueError) as error:
            raise type(error)(f"reward: expected a number for {name}, not {weight!r}") from None
    return weights


# Memory of a world, MB: less than that of the smallest task.
_LEAST_WORLD_MB = 0.5


def _check_memory(worlds: int) -> None:
    """Raises a MemoryError if so many worlds cannot fit in memory. A failed allocation would end the whole interpreter."""
    needed, available = _LEAST_WORLD_MB * worlds, _available_mb()
    if available is not None and needed > available:
        raise MemoryError(
            f"num_envs: {worlds:,} worlds need more than {needed / 1000:,.1f} GB; {available / 1000:,.1f} GB are available"
        )


def _available_mb() -> float | None:
    """Returns the memory that this process can still allocate, MB; None on systems without ``/proc``."""
    try:
        with open("/proc/meminfo") as file:
            available = next(int(line.split()[1]) / 1000 for line in file if line.startswith("MemAvailable:"))
        import resource

        most = resource.getrlimit(resource.RLIMIT_AS)[0]
        if most != resource.RLIM_INFINITY:
            with open("/proc/self/statm") as file:
                used = int(file.read().split()[0]) * resource.getpagesize()
            available = min(available, max(0, most - used) / 1e6)
    except (OSError, StopIteration, ValueError, ImportError):
        return None
    return available


def agent_name(robot: str) -> str:
    """The name of a robot as an agent: ``blue_1``."""
    return f"{robot[:4]}_{robot[4:]}"
