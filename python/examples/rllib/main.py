"""A team of two learns with RLlib's PPO, one policy for both: ``python main.py [iterations]``."""

from __future__ import annotations

import sys

from ray.rllib.algorithms.ppo import PPOConfig

from naoisis.rllib import MatchEnv

TASK = {"scenario": "TwoOnTwo", "control": "blue", "observation": "belief", "action": "discrete"}


def main(iterations: int = 20) -> float:
    """Learns for so many iterations. The mean return of the last one."""
    config = (
        PPOConfig()
        .environment(MatchEnv, env_config=TASK)
        # Environments in processes of their own: num_env_runners=8, on any machine of Ray's cluster.
        .env_runners(num_env_runners=0, rollout_fragment_length=512)
        .training(train_batch_size=1024, minibatch_size=256, num_epochs=4, gamma=0.995, lr=5e-4, entropy_coeff=0.01)
        .multi_agent(policies={"team"}, policy_mapping_fn=lambda agent, episode, **_: "team")
    )
    algorithm = config.build_algo()
    mean = float("nan")
    for iteration in range(1, iterations + 1):
        mean = algorithm.train()["env_runners"].get("episode_return_mean", float("nan"))
        print(f"iteration {iteration}: mean return {mean:.2f}", flush=True)
    algorithm.stop()
    return mean


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
