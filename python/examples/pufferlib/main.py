"""An environment for PufferLib 3, whose worlds write directly into the learner's buffers: ``python main.py [steps]`` takes random actions
in it.

PufferLib gives each environment its slice of one shared buffer, with one row for each agent, and ``step_into`` fills this slice. The
example also runs without PufferLib: it then allocates the buffers itself.
"""

from __future__ import annotations

import sys
from types import SimpleNamespace

import numpy as np

import naoisis

try:
    from pufferlib import PufferEnv
except ImportError:

    class PufferEnv:
        """A replacement for PufferLib's class: allocates buffers of the right shapes."""

        def __init__(self, buf: SimpleNamespace | None = None):
            rows, space = self.num_agents, self.single_observation_space
            self.observations = np.zeros((rows, *space.shape), space.dtype)
            self.rewards = np.zeros(rows, np.float32)
            self.terminals, self.truncations, self.masks = (
                np.zeros(rows, bool),
                np.zeros(rows, bool),
                np.ones(rows, bool),
            )
            self.actions = np.zeros((rows, *self.single_action_space.shape), self.single_action_space.dtype)


class Soccer(PufferEnv):
    """``worlds`` worlds of ``task`` as one environment. Its agents are the robots of team blue in all worlds."""

    def __init__(
        self, task: str = "TwoOnTwo", worlds: int = 16, buf: SimpleNamespace | None = None, seed: int = 0, **options
    ):
        self.envs = naoisis.vector_env(
            task, worlds, control="blue", action="discrete", autoreset_mode="same_step", **options
        )
        self.single_observation_space = self.envs.single_observation_space
        self.single_action_space = self.envs.single_action_space
        self.num_agents = self.envs.num_envs
        super().__init__(buf)

    def reset(self, seed: int | None = None):
        """Starts an episode in each world, and returns the observations and an empty list of infos."""
        self.observations[:] = self.envs.reset(seed=seed)[0]
        return self.observations, []

    def step(self, actions: np.ndarray):
        """Steps all worlds, and returns the filled buffers and, if an episode has ended, a list with the share of successful ones."""
        info = self.envs.step_into(actions, self.observations, self.rewards, self.terminals, self.truncations)
        success = [{"success": float(info["final_info"]["success"][info["_final_info"]].mean())}] if info else []
        return self.observations, self.rewards, self.terminals, self.truncations, success

    def close(self):
        self.envs.close()


def main(steps: int = 1000) -> float:
    """Plays ``steps`` steps with random actions, and returns the mean reward."""
    env, random = Soccer(observation="belief"), np.random.default_rng(1)
    env.reset(seed=1)
    rewards = [
        env.step(random.integers(env.single_action_space.n, size=env.num_agents))[1].mean() for _ in range(steps)
    ]
    print(f"{steps} steps of {env.num_agents} agents, mean reward {np.mean(rewards):.4f}")
    env.close()
    return float(np.mean(rewards))


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
