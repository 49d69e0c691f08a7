"""Trains a team of two with RLlib's PPO; both robots share one policy: ``python main.py [iterations] [--runners 2]``."""

from __future__ import annotations

import argparse

from ray.rllib.algorithms.ppo import PPOConfig

from naoisis.rllib import MatchEnv

TASK = {"scenario": "TwoOnTwo", "control": "blue", "observation": "belief", "action": "discrete"}


def main(iterations: int = 20, runners: int = 0) -> float:
    """Trains for ``iterations`` iterations, and returns the mean episode return of the last one: NaN if no episode has ended.

    Matches are played in ``runners`` other processes, on any machine of Ray's cluster, or in this process if ``runners`` is 0.
    """
    # Each runner collects its part of a batch.
    rows = 1024 // max(runners, 2)
    config = (
        PPOConfig()
        .environment(MatchEnv, env_config=TASK)
        .env_runners(num_env_runners=runners, rollout_fragment_length=rows)
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
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("iterations", type=int, nargs="?", default=20)
    parser.add_argument(
        "--runners",
        type=int,
        default=0,
        help="the number of other processes that play matches; 0: only this process [%(default)s]",
    )
    main(**vars(parser.parse_args()))
