"""Environments of RLlib. Needs ``pip install naoisis[rllib]``.

>>> from ray.rllib.algorithms.ppo import PPOConfig
>>> from naoisis.rllib import MatchEnv
>>> config = PPOConfig().environment(MatchEnv, env_config={"scenario": "TwoOnTwo", "control": "blue"})
>>> config = config.multi_agent(policies={"team"}, policy_mapping_fn=lambda agent, episode, **_: "team")
"""

from __future__ import annotations

from typing import Any

from ray.rllib.env.multi_agent_env import MultiAgentEnv

import naoisis

__all__ = ["MatchEnv"]


class MatchEnv(MultiAgentEnv):
    """The robots of a match, or of a task, as agents ``blue_1`` and so on.

    Args:
        config: The arguments of :func:`naoisis.parallel_env`, by their names.
    """

    def __init__(self, config: dict[str, Any] | None = None):
        super().__init__()
        self.env = naoisis.parallel_env(**dict(config or {}))
        self.possible_agents = list(self.env.possible_agents)
        self.agents = list(self.possible_agents)
        self.observation_spaces = dict(self.env.observation_spaces)
        self.action_spaces = dict(self.env.action_spaces)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, Any], dict[str, Any]]:
        observations, infos = self.env.reset(seed=seed, options=options)
        self.agents = list(self.possible_agents)
        return observations, infos

    def step(self, actions: dict[str, Any]) -> tuple[dict[str, Any], ...]:
        observations, rewards, terminations, truncations, infos = self.env.step(actions)
        terminations["__all__"] = all(terminations.values())
        truncations["__all__"] = all(truncations.values())
        return observations, rewards, terminations, truncations, infos

    def render(self) -> Any:
        return self.env.render()
