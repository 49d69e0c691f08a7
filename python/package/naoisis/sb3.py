"""Environments of Stable-Baselines3, natively: no wrappers, no processes. Needs ``pip install naoisis[sb3]``.

>>> from stable_baselines3 import PPO
>>> from naoisis.sb3 import VecEnv
>>> model = PPO("MlpPolicy", VecEnv("ScoreEmptyGoal", num_envs=16, action="discrete"))
>>> model = model.learn(10_000)
>>> policy = naoisis.export_policy(naoisis.sb3.actor(model), "score.onnx", model.env)
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from gymnasium import spaces
from stable_baselines3.common import vec_env
from stable_baselines3.common.on_policy_algorithm import OnPolicyAlgorithm
from stable_baselines3.common.policies import ActorCriticPolicy
from torch import Tensor, nn

from naoisis._arguments import Scenario
from naoisis.environments import VectorEnv

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from naoisis._worlds import WorldOptions

__all__ = ["VecEnv", "actor"]


class VecEnv(vec_env.VecEnv):
    """Many worlds that are stepped together: one row for each agent of each world. The arguments are those of :class:`naoisis.VectorEnv`.

    The options of ``set_options`` are those of :class:`naoisis.VectorEnv`; they hold for all episodes until the next reset.

    All agents share one policy. A step that ends an episode returns the first observation of the next one; the last one
    is in ``infos[row]["terminal_observation"]``, and ``infos[row]["TimeLimit.truncated"]`` says whether its time limit ended it.
    """

    def __init__(
        self,
        scenario: Scenario = "ScoreEmptyGoal",
        num_envs: int = 1,
        *,
        threads: int | None = None,
        render_mode: str | None = None,
        **options: Unpack[WorldOptions],
    ):
        self.envs = VectorEnv(
            scenario, num_envs, autoreset_mode="same_step", threads=threads, render_mode=render_mode, **options
        )
        self._actions: np.ndarray | None = None
        self._seed: int | None = None
        # The base class asks for it.
        self.render_mode = self.envs.render_mode
        super().__init__(self.envs.num_envs, self.envs.single_observation_space, self.envs.single_action_space)

    def seed(self, seed: int | None = None) -> Sequence[int | None]:
        self._seed = seed
        return [None if seed is None else seed + row // len(self.envs.agents) for row in range(self.num_envs)]

    def reset(self) -> Any:
        agents = len(self.envs.agents)
        of_worlds = [self._options[row] for row in range(0, self.num_envs, agents)]
        if any(options != of_worlds[row // agents] for row, options in enumerate(self._options)):
            raise ValueError("set_options: agents of one world differ; expected the same for all of them")
        options = {repr(options): options for options in of_worlds}
        first, *others = options
        observations, _ = self.envs.reset(seed=self._seed, options=options[first] or None)
        for name in others:
            mask = np.repeat([repr(of_world) == name for of_world in of_worlds], agents)
            changed = {**options[name], "reset_mask": mask}
            observations, _ = self.envs.reset(seed=self._seed, options=changed)
        self._seed = None
        self._reset_options()
        return observations

    def step_async(self, actions: np.ndarray) -> None:
        self._actions = actions

    def step_wait(self) -> tuple[Any, np.ndarray, np.ndarray, list[dict[str, Any]]]:
        observations, rewards, terminations, truncations, info = self.envs.step(self._actions)
        dones = terminations | truncations
        infos: list[dict[str, Any]] = [{} for _ in range(self.num_envs)]
        for row in np.flatnonzero(dones).tolist():
            ended = info["final_info"]
            infos[row] = {
                **_of_row({name: value for name, value in ended.items() if "state" not in name}, row),
                "terminal_observation": info["final_obs"][row],
                "TimeLimit.truncated": bool(truncations[row] and not terminations[row]),
                "is_success": bool(ended["success"][row]),
            }
        return observations, rewards, dones, infos

    def close(self) -> None:
        self.envs.close()

    def get_images(self) -> Sequence[np.ndarray | None]:
        pictures = self.envs.render() or ()
        return [*pictures, *[None] * (self.num_envs - len(pictures))][: self.num_envs]

    def get_attr(self, attr_name: str, indices: Any = None) -> list[Any]:
        return [getattr(self.envs, attr_name)] * len(list(self._get_indices(indices)))

    def set_attr(self, attr_name: str, value: Any, indices: Any = None) -> None:
        setattr(self.envs, attr_name, value)

    def env_method(self, method_name: str, *arguments: Any, indices: Any = None, **options: Any) -> list[Any]:
        result = getattr(self.envs, method_name)(*arguments, **options)
        if method_name == "action_masks":
            # The libraries that ask for masks expect one row from each environment.
            return [result[row] for row in self._get_indices(indices)]
        return [result] * len(list(self._get_indices(indices)))

    def env_is_wrapped(self, wrapper_class: type, indices: Any = None) -> list[bool]:
        return [False] * len(list(self._get_indices(indices)))


def _of_row(info: dict[str, Any], row: int) -> dict[str, Any]:
    """The info of a row, out of the arrays of all rows."""
    of_row = {}
    for name, value in info.items():
        if f"_{name}" in info and info[f"_{name}"][row]:
            of_row[name] = _of_row(value, row) if isinstance(value, dict) else value[row]
    return of_row


def actor(model: OnPolicyAlgorithm) -> nn.Module:
    """The actor of a model of PPO or A2C, for :func:`naoisis.export_policy`: the scores of choices, or the means of numbers."""
    policy = model.policy
    if not isinstance(policy, ActorCriticPolicy) or hasattr(policy, "lstm_actor"):
        raise TypeError(f"model: expected one with an actor and a critic, such as PPO, not {policy!r}")
    return _Actor(policy)


class _Actor(nn.Module):
    def __init__(self, policy: ActorCriticPolicy):
        super().__init__()
        self.policy = policy

    def forward(self, observation: Tensor) -> Tensor:
        features = self.policy.extract_features(observation)
        # There are two where the critic has its own.
        features = features[0] if isinstance(features, tuple) else features
        outputs: Tensor = self.policy.action_net(self.policy.mlp_extractor.forward_actor(features))
        return outputs.clamp(-1.0, 1.0) if isinstance(self.policy.action_space, spaces.Box) else outputs
