"""Tasks of BenchMARL. Needs ``pip install naoisis[benchmarl]``.

>>> from naoisis.benchmarl import MatchTask
>>> task = MatchTask("FirstGoal", {"control": "blue", "opponents": "chasers", "observation": "belief"})

``Experiment(task=task, ...)`` takes it as the tasks that BenchMARL brings.
"""

from __future__ import annotations

import copy
from collections.abc import Callable
from typing import Any

from benchmarl.environments import TaskClass
from torchrl.data import Composite
from torchrl.envs import EnvBase

from naoisis.torchrl import MatchEnv

__all__ = ["MatchTask"]

MAX_STEPS = 600


class MatchTask(TaskClass):
    """A match, or a named task, whose teams are the groups of agents. Critics can use the true state.

    Args:
        name: A task's name (:func:`naoisis.tasks`), or a built-in scenario's.
        config: The other arguments of :class:`naoisis.torchrl.MatchEnv` but the seed, the device and the number of worlds, and ``max_steps``,
            the steps of an evaluation [default: 600]. ``action`` is that of algorithms with discrete actions, ``"discrete"`` or
            ``"velocities"`` [default: ``"discrete"``].
    """

    def __init__(self, name: str, config: dict[str, Any] | None = None):
        super().__init__(name=name, config=dict(config or {}))

    def get_env_fun(
        self, num_envs: int, continuous_actions: bool, seed: int | None, device: Any
    ) -> Callable[[], EnvBase]:
        options = copy.deepcopy(self.config)
        options.pop("max_steps", None)
        discrete = options.pop("action", "discrete")
        action = "continuous" if continuous_actions else discrete
        return lambda: MatchEnv(self.name, num_envs, seed=seed, device=device, action=action, **options)

    def supports_continuous_actions(self) -> bool:
        return True

    def supports_discrete_actions(self) -> bool:
        return True

    def max_steps(self, env: EnvBase) -> int:
        return int(self.config.get("max_steps", MAX_STEPS))

    def has_render(self, env: EnvBase) -> bool:
        return True

    def group_map(self, env: EnvBase) -> dict[str, list[str]]:
        groups: dict[str, list[str]] = env.group_map
        return groups

    def observation_spec(self, env: EnvBase) -> Composite:
        return self._without(env, "state", "info")

    def info_spec(self, env: EnvBase) -> Composite:
        return self._without(env, "state", "observation", "pixels")

    def state_spec(self, env: EnvBase) -> Composite:
        return self._without(env, *self.group_map(env))

    def action_spec(self, env: EnvBase) -> Composite:
        return env.full_action_spec_unbatched

    def action_mask_spec(self, env: EnvBase) -> None:
        return None

    def _without(self, env: EnvBase, *names: str) -> Composite:
        """The observations of a world, without some entries of it or of groups."""
        spec = env.full_observation_spec_unbatched.clone()
        for name in list(spec.keys()):
            if name in names:
                del spec[name]
            elif name in self.group_map(env):
                for entry in [entry for entry in spec[name].keys() if entry in names]:
                    del spec[name, entry]
        return spec

    @staticmethod
    def log_info(batch: Any) -> dict[str, float]:
        """The share of the episodes that ended in a batch with success, of each group."""
        ended = batch["next", "done"].squeeze(-1)
        if not ended.any():
            return {}
        groups = [key[0] for key in batch["next"].keys(True) if isinstance(key, tuple) and key[1:] == ("info",)]
        return {
            f"collection/{group}/success_rate": float(batch["next", group, "info", "success"][ended].float().mean())
            for group in groups
        }

    @staticmethod
    def env_name() -> str:
        return "naoisis"
