"""PufferLib's way: worlds write into slices of buffers that the learner owns, in place. ``python main.py [steps]``

PufferLib 3 lays agents along the batch and hands each environment its part of one shared buffer; ``step_into`` fills exactly that.
This is such an environment, and runs without PufferLib, too: then it makes the buffers itself.
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
        """What PufferLib's own does for an environment: buffers of the right shapes."""

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
    """Many worlds of a task, as one environment with many agents."""

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
        self.observations[:] = self.envs.reset(seed=seed)[0]
        return self.observations, []

    def step(self, actions: np.ndarray):
        info = self.envs.step_into(actions, self.observations, self.rewards, self.terminals, self.truncations)
        success = [{"success": float(info["final_info"]["success"][info["_final_info"]].mean())}] if info else []
        return self.observations, self.rewards, self.terminals, self.truncations, success

    def close(self):
        self.envs.close()


def main(steps: int = 1000) -> float:
    """Plays so many steps by chance. The mean reward."""
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
