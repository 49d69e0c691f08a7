"""Environments of Gymnasium: one robot that learns, and many worlds in step."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import gymnasium
import numpy as np
from gymnasium import spaces
from gymnasium.vector import AutoresetMode
from gymnasium.vector.utils import batch_space

from naoisis import _naoisis
from naoisis._arguments import Scenario, count_of
from naoisis._infos import vector_info
from naoisis._options import check_options
from naoisis._view import View, check_render_mode, modes_here
from naoisis._worlds import Worlds
from naoisis.errors import MatchError

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from naoisis._worlds import WorldOptions

__all__ = ["MatchEnv", "VectorEnv", "register", "vector_env"]


class MatchEnv(gymnasium.Env):
    """One robot in a match, or in a named task such as ``"ScoreEmptyGoal"``.

    >>> import gymnasium, naoisis
    >>> env = gymnasium.make("naoisis/ScoreEmptyGoal-v0", observation="belief")
    >>> observation, info = env.reset(seed=1)
    >>> observation, reward, terminated, truncated, info = env.step(env.action_space.sample())

    Args:
        scenario: A task's name (:func:`naoisis.tasks`), or a scenario as of :class:`naoisis.Match`.
        control: The robot, such as ``"blue2"`` [default: the task's].
        opponents: The name of the other team, if the scenario has teams; from a list of names one is drawn for each episode.
        observation: ``"perception"`` (sensors, and the game status that the robot received), ``"belief"`` (the built-in estimator), ``"truth"``
            (the true state), or ``"image"`` (a dictionary of a camera image and the state of the body).
        action: ``"continuous"``, ``"multi_discrete"``, ``"discrete"`` or ``"velocities"``: see ``action_names``.
        reward: Weights of the terms of the reward (:func:`naoisis.rewards`), a function of the states of all worlds
            (:func:`naoisis.batch_reward`), or a function of the truth and the robot's name [default: the task's, else the score].
        cycles_per_step: Cycles for which an action is held [default: the task's, else 3].
        set: Fields of the scenario to change.
        realism: The level of realism; from a list of levels one is drawn for each episode. In ``"realistic"``, tasks of the paper's NAO have
            the NAO V6, as in ``naoisis challenge``. Spaces are wide enough for each level, so that a reset can set another one.
        draws: Fields of the scenario that are drawn for each episode: a tuple of two numbers is a range, a list has the possible values, as in
            ``{"messages.loss": (0.0, 0.3), "messages.delay_cycles": range(1, 11)}``. Whole numbers need a list or a ``range``.
        extras: What is observed besides: ``"set_plays"`` (set plays, drop balls and stops that the robot was told of), ``"penalties"``
            (which other robots are penalised, in the order of their numbers), ``"messages"`` (the last message of each team-mate, in the order of their numbers), ``"tracked"`` (other robots keep their places in the
            observation while they are followed; otherwise the nearest is first).
        observed_robots: The numbers of team-mates and of opponents in an observation: the nearest ones if the match has more, and unknown
            ones if it has fewer, so that a policy plays in matches with any number of robots [default: those of the match].
        says: The number of words, 0 to 8, that a robot can say to its team-mates as a part of its action. Continuous actions have
            one more number for each, and one that sends them; others, except ``"discrete"``, have one more list of choices.
        statistics: Whether ``info["statistics"]`` at the end of an episode has the counts of both teams: goals, shots, kicks, passes, possession,
            distance, falls, penalties, by the definitions of a match. An episode that was copied or pickled in its middle has none.
        camera: The name of the camera of images in the robot's model: for a NAO ``"top"`` or ``"bottom"``, for a Booster K1
            ``"head"`` [default: the robot's first].
        image_size: Height and width of images, pixels.
        render_mode: ``"rgb_array"`` for pictures of the field, ``"human"`` for a window, which needs a display and Tk.

    The ``options`` of a reset apply to the episodes until the next reset: ``set`` are fields of the scenario to change,
    ``draws`` are fields to draw instead of those of the environment, ``situation`` are start areas as in a task's file, and ``snapshot`` is a moment to start from, of
    :meth:`naoisis.Match.snapshot` or :meth:`snapshot`, each time with other random numbers.

    The info of a reset has ``match_seed``, the seed of the match, and what was drawn for it: ``opponents``, ``realism`` and ``drawn``, as far as there
    is a choice. The info at the end of an episode has them, too, and ``success``. ``reset(options={"match_seed": ...})`` plays that episode again.

    The end of a task, and the final whistle, terminate an episode; its time limit truncates it. ``info["success"]`` says
    whether the task ended with success for the agent's team, such as with its goal. A penalised robot stays an agent, with ``body.penalised`` in its observation.

    Attributes:
        observation_names: The names of the numbers of an observation.
        observation_entries: For each its name, least and greatest value, and meaning.
        action_names: The names of the numbers of an action, or of the choices, one list per choice.
        reward_weights: The weights of the terms of the reward; none if it is a function.
    """

    metadata = {"render_modes": ["rgb_array", "human"], "render_fps": 10}

    def __init__(
        self,
        scenario: Scenario = "ScoreEmptyGoal",
        *,
        render_mode: str | None = None,
        **options: Unpack[WorldOptions],
    ):
        self._view = View(render_mode, ("rgb_array", "human"))
        self._worlds = Worlds(scenario, solo=True, **options)
        self.render_mode = render_mode
        self.observation_space = self._worlds.observation_space
        self.action_space = self._worlds.action_space
        self.observation_names = self._worlds.observation_names
        self.observation_entries = self._worlds.observation_entries
        self.action_names = self._worlds.action_names
        has_own_reward = self._worlds.own_reward is not None or self._worlds.batch_reward is not None
        self.reward_weights = {} if has_own_reward else self._worlds.inner.reward
        self.metadata = {"render_modes": modes_here(), "render_fps": round(1 / self._worlds.step_s)}
        self._has_seed = False

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        super().reset(seed=seed)
        check_options(options)
        if seed is None and not self._has_seed:
            seed = int(self.np_random.integers(2**32))
        arrays = self._worlds.arrays()
        self._worlds.reset(seed, arrays, options)
        self._has_seed = True
        self._view.show(self._worlds)
        return self._worlds.row(self._worlds.observations(arrays), 0), self._worlds.origin(0)

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        arrays = self._worlds.arrays()
        self._worlds.step(action, arrays)
        self._view.show(self._worlds)
        observation = self._worlds.row(self._worlds.observations(arrays), 0)
        terminated, truncated = bool(arrays["terminations"][0]), bool(arrays["truncations"][0])
        info = {"success": bool(arrays["successes"][0]), **self._worlds.ended(0)} if terminated or truncated else {}
        return observation, float(arrays["rewards"][0]), terminated, truncated, info

    def truth(self) -> dict[str, Any]:
        """The current truth: see :meth:`naoisis.Match.truth`. With the observation ``"truth"``, controlled robots perceive nothing."""
        return self._worlds.inner.truth(0)

    def snapshot(self) -> bytes:
        """A snapshot of the match, to start episodes from: ``reset(options={"snapshot": ...})``. Robots see in the first observation what
        they saw in the snapshot: nothing, if the truth is observed here. A robot without a belief in it begins with its true pose, if beliefs are
        observed there, as at the start of a match."""
        return self._worlds.inner.snapshot(0)

    def state(self) -> np.ndarray:
        """The true state as an array, for critics, in the frame of the blue team; its names are ``state_names``."""
        state: np.ndarray = self._worlds.inner.state()[0]
        return state

    def action_masks(self) -> np.ndarray:
        """For each choice, list by list, whether it has an effect now: the robot can walk or kick, and has the kick. For actions that are choices."""
        masks: np.ndarray = self._worlds.action_masks()[0]
        return masks

    @property
    def state_names(self) -> list[str]:
        """The names of the numbers of :meth:`state`."""
        return list(self._worlds.state_names)

    @property
    def state_entries(self) -> list[tuple[str, float, float, str]]:
        """For each number of :meth:`state` its name, least and greatest value, and meaning."""
        return self._worlds.inner.state_entries()

    def render(self) -> np.ndarray | None:
        return self._worlds.picture() if self.render_mode == "rgb_array" else None

    def close(self) -> None:
        self._view.close()


class VectorEnv(gymnasium.vector.VectorEnv):
    """Many worlds that are stepped together, on several threads: one row per agent; the agents of a world are neighbours.

    Same seeds and actions give the same bytes on any number of threads.

    Args:
        num_envs: The number of worlds; with several agents in each, the attribute ``num_envs`` is that of the rows.
        control: Robots, such as ``["blue1", "blue2"]``, or a team, ``"blue"`` [default: the task's one robot].
        autoreset_mode: When a world starts its next episode: ``"next_step"`` (in its next step),
            ``"same_step"`` (at once; ``info["final_obs"]`` has the last observation), or ``"disabled"``
            (by ``reset(options={"reset_mask": ...})``, with a mask of the worlds).
        threads: The number of threads [default: one per core].
        reward: As of :class:`MatchEnv`. A function of the truth costs the time for a dictionary for each world and step; one that
            :func:`naoisis.batch_reward` has made is called once for all worlds.

    The other arguments are those of :class:`MatchEnv`. Infos have arrays with a value for each row, and beside each ``name`` the array ``_name``,
    which is true for the rows that have a value. What an episode began from is in the info of the reset or step that begins it.
    With ``"same_step"``, ``info["final_info"]`` is the info at the end of episodes, with the last ``state`` of each world.

    Attributes:
        num_worlds: The number of worlds.
        state_space: The space of a row of :meth:`state`.
        agents: The robots of each world, in the order of the rows.
    """

    metadata = {"render_modes": ["rgb_array"], "render_fps": 10, "autoreset_mode": AutoresetMode.NEXT_STEP}

    def __init__(
        self,
        scenario: Scenario = "ScoreEmptyGoal",
        num_envs: int = 1,
        *,
        autoreset_mode: str | AutoresetMode = "next_step",
        threads: int | None = None,
        render_mode: str | None = None,
        **options: Unpack[WorldOptions],
    ):
        check_render_mode(render_mode, ("rgb_array",))
        mode = str(getattr(autoreset_mode, "name", autoreset_mode)).lower()
        if mode == "same_step" and callable(options.get("reward")):
            raise ValueError(
                "reward: a function of the truth cannot look at the end of an episode when the next one begins in the same step; "
                "expected weights, a function made by `naoisis.batch_reward`, or another autoreset_mode"
            )
        self._worlds = worlds = Worlds(
            scenario, worlds=num_envs, auto_reset=mode, threads=threads, solo=options.get("control") is None, **options
        )
        self.autoreset_mode = AutoresetMode[mode.upper()]
        self.metadata = {**self.metadata, "render_fps": round(1 / worlds.step_s), "autoreset_mode": self.autoreset_mode}
        self.render_mode = render_mode
        self.num_envs, self.num_worlds, self.agents = worlds.rows, worlds.worlds, worlds.agents
        self.single_observation_space, self.single_action_space = worlds.observation_space, worlds.action_space
        self.observation_space = batch_space(worlds.observation_space, worlds.rows)
        self.action_space = batch_space(worlds.action_space, worlds.rows)
        self.observation_names, self.action_names = worlds.observation_names, worlds.action_names
        low, high = (np.array([entry[side] for entry in worlds.inner.state_entries()], np.float32) for side in (1, 2))
        self.state_space = spaces.Box(low, high, dtype=np.float32)
        self._last: dict[str, np.ndarray] = {}
        # The rows whose episodes are over and begin with the next step, if there are any.
        self._waits: np.ndarray | None = None

    def reset(
        self,
        *,
        seed: int | list[int] | None = None,
        options: dict[str, Any] | None = None,
    ) -> tuple[Any, dict[str, Any]]:
        """Starts episodes, in all worlds or in those of ``options["reset_mask"]``; ``seed`` is that of the first world.

        The other options are those of :class:`MatchEnv`. They apply to these worlds until their next call of this method.
        """
        if self.closed:
            raise MatchError("the environment is closed; expected no reset after that")
        if isinstance(seed, (list, tuple)):
            if len(seed) != self.num_worlds or list(seed) != list(range(seed[0], seed[0] + len(seed))):
                raise ValueError(
                    f"seed: {seed} are not {self.num_worlds} consecutive seeds; expected the first one only"
                )
            seed = seed[0]
        super().reset(seed=seed)
        check_options(options, "reset_mask")
        arrays = self._worlds.arrays()
        mask = (options or {}).get("reset_mask")
        if mask is not None:
            mask = self._mask_of_worlds(mask)
            # What is not reset is as it was.
            for name in ("observations", "images"):
                arrays[name][...] = self._last.get(name, 0)
        elif seed is None and not self._last:
            seed = int(self.np_random.integers(2**32))
        self._worlds.reset(seed, arrays, options, mask)
        self._waits = None
        self._last = arrays
        begun = np.ones(self.num_worlds, np.bool_) if mask is None else mask
        return self._worlds.observations(self._copies(arrays)), self._origins(begun)

    def _origins(self, begun: np.ndarray) -> dict[str, Any]:
        """What the episodes of some worlds began from, as an info."""
        agents = len(self.agents)
        of_rows: dict[int, dict[str, Any]] = {}
        for world in np.flatnonzero(begun).tolist():
            origin = self._worlds.origin(world)
            of_rows |= {world * agents + agent: origin for agent in range(agents)}
        return vector_info(of_rows, self.num_envs)

    def step(self, actions: Any) -> tuple[Any, np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        arrays = self._worlds.arrays(self.autoreset_mode == AutoresetMode.SAME_STEP)
        info = self._step_into(actions, arrays)
        self._last = arrays
        observations = self._worlds.observations(self._copies(arrays))
        return observations, arrays["rewards"], arrays["terminations"], arrays["truncations"], info

    def step_into(
        self,
        actions: Any,
        observations: np.ndarray,
        rewards: np.ndarray,
        terminations: np.ndarray,
        truncations: np.ndarray,
        images: np.ndarray | None = None,
    ) -> dict[str, Any]:
        """Plays a step and fills the caller's arrays, without allocating. Returns the info.

        Args:
            observations: ``float32`` (num_envs, numbers of an observation).
            rewards: ``float32`` (num_envs,).
            terminations: ``bool`` (num_envs,).
            truncations: ``bool`` (num_envs,).
            images: ``uint8`` (num_envs, height, width, 3), if images are observed.
        """
        arrays = self._worlds.arrays(self.autoreset_mode == AutoresetMode.SAME_STEP)
        arrays |= {
            "observations": observations,
            "rewards": rewards,
            "terminations": terminations,
            "truncations": truncations,
        }
        if images is not None:
            arrays["images"] = images
        self._worlds.check_arrays(arrays)
        return self._step_into(actions, arrays)

    def _step_into(self, actions: Any, arrays: dict[str, np.ndarray]) -> dict[str, Any]:
        if self.closed:
            raise MatchError("the environment is closed; expected no step after that")
        is_any_over = self._worlds.step(actions, arrays)
        agents = len(self.agents)
        begun = self._waits if self.autoreset_mode == AutoresetMode.NEXT_STEP else None
        if begun is not None:
            # These have just begun, whatever one's own reward says of them.
            arrays["rewards"][begun] = 0.0
        self._waits = None
        if not is_any_over:
            return {} if begun is None else self._origins(begun[::agents])
        over = self._waits = arrays["terminations"] | arrays["truncations"]
        rows = np.flatnonzero(over).tolist()
        of_rows = {row: self._worlds.ended(row // agents, row % agents) for row in rows}
        if self.autoreset_mode != AutoresetMode.SAME_STEP:
            for row in [] if begun is None else np.flatnonzero(begun).tolist():
                of_rows[row] = self._worlds.origin(row // agents)
            return {"success": arrays["successes"], "_success": over, **vector_info(of_rows, self.num_envs)}
        ended = {"success": arrays["successes"], "_success": over, **vector_info(of_rows, self.num_envs)}
        ended |= {"state": np.repeat(arrays["final_states"], agents, axis=0), "_state": over}
        last = self._worlds.observations(arrays, "final_")
        final = np.full(self.num_envs, None, dtype=object)
        for row in rows:
            final[row] = self._worlds.row(last, row)
        self._worlds.let_go_of_finals()
        return {
            "final_obs": final,
            "_final_obs": over.copy(),
            "final_info": ended,
            "_final_info": over.copy(),
            **self._origins(over[::agents]),
        }

    def _mask_of_worlds(self, mask: Any) -> np.ndarray:
        if not isinstance(mask, np.ndarray) or mask.dtype != np.bool_ or mask.shape != (self.num_envs,):
            raise ValueError(f"reset_mask: expected an array of bool of shape ({self.num_envs},), not {mask!r}")
        of_worlds = mask.reshape(self.num_worlds, -1)
        if (of_worlds.any(axis=1) != of_worlds.all(axis=1)).any():
            raise ValueError("reset_mask: agents of one world differ; expected the same for all of them")
        return np.ascontiguousarray(of_worlds[:, 0])

    def _copies(self, arrays: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
        """The observations, copied for worlds that are not reset."""
        if self.autoreset_mode != AutoresetMode.DISABLED:
            return arrays
        return {name: arrays[name].copy() for name in ("observations", "images")}

    def snapshot(self, world: int = 0) -> bytes:
        """A snapshot of a world, to start episodes from: ``reset(options={"snapshot": ...})``. Robots see in the first observation what
        they saw in the snapshot: nothing, if the truth is observed here. A robot without a belief in it begins with its true pose, if beliefs are
        observed there, as at the start of a match."""
        return self._worlds.inner.snapshot(count_of(world, "world", least=0))

    def state(self) -> np.ndarray:
        """The true state of each world, in the frame of the blue team: ``float32`` (num_worlds, numbers), named by ``state_names``."""
        return self._worlds.inner.state()

    def truth(self, world: int = 0) -> dict[str, Any]:
        """The current truth of a world: see :meth:`naoisis.Match.truth`."""
        return self._worlds.inner.truth(count_of(world, "world", least=0))

    def action_masks(self) -> np.ndarray:
        """For each row and each choice, list by list, whether it has an effect now: ``bool`` (num_envs, choices). See :class:`MatchEnv`."""
        return self._worlds.action_masks()

    @property
    def state_names(self) -> list[str]:
        """The names of the numbers of :meth:`state`."""
        return list(self._worlds.state_names)

    def render(self) -> tuple[np.ndarray, ...] | None:
        """Pictures of the fields of the first worlds."""
        if self.render_mode != "rgb_array":
            return None
        return tuple(self._worlds.picture((270, 480), world) for world in range(min(self.num_worlds, 16)))


def vector_env(
    scenario: Scenario = "match3v3",
    num_envs: int = 1,
    *,
    autoreset_mode: str | AutoresetMode = "next_step",
    threads: int | None = None,
    render_mode: str | None = None,
    **options: Unpack[WorldOptions],
) -> VectorEnv:
    """Many worlds that are stepped together: see :class:`VectorEnv`."""
    return VectorEnv(
        scenario, num_envs, autoreset_mode=autoreset_mode, threads=threads, render_mode=render_mode, **options
    )


def register() -> None:
    """Registers the tasks in Gymnasium, as ``naoisis/NAME-vN``, as ``naoisis/NAME_unseen-vN`` with opponents and a robot that are held out,
    and as ``naoisis/NAME_images-vN`` for robots that see by camera images alone.

    Importing :mod:`naoisis` does it, and so does the name of the module in ``gymnasium.make("naoisis:naoisis/NAME-vN")``.
    """
    for seen, version, _ in _naoisis.challenges():
        for name in (seen, f"{seen}_unseen", f"{seen}_images", f"{seen}_images_unseen"):
            gymnasium.register(
                id=f"naoisis/{name}-v{version}",
                entry_point="naoisis.environments:MatchEnv",
                vector_entry_point="naoisis.environments:VectorEnv",
                kwargs={"scenario": name},
            )
