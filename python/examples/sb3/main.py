"""Trains a robot to score with Stable-Baselines3, in one or two minutes: ``python main.py [steps]``.

The policy is written to ``score.onnx``; ``naoisis challenge ScoreEmptyGoal --policy score.onnx`` measures its success rate.
"""

from __future__ import annotations

import sys

import numpy as np
from stable_baselines3 import PPO
from stable_baselines3.common.evaluation import evaluate_policy
from stable_baselines3.common.vec_env import VecMonitor

import naoisis
from naoisis.sb3 import VecEnv, actor


def main(steps: int = 100_000) -> float:
    """Trains for ``steps`` environment steps, and returns the mean return of the trained policy in 50 episodes."""
    envs = VecMonitor(VecEnv("ScoreEmptyGoal", num_envs=16, observation="belief", action="discrete"))
    model = PPO("MlpPolicy", envs, n_steps=128, batch_size=256, gamma=0.99, ent_coef=0.01, seed=1, device="cpu")
    model.learn(steps)
    returns, _ = evaluate_policy(model, envs, n_eval_episodes=50, return_episode_rewards=True)
    print(f"mean return {np.mean(returns):.2f}, {np.mean(np.array(returns) > 8):.0%} of 50 episodes with a goal")
    naoisis.export_policy(actor(model), "score.onnx", envs, interactions=model.num_timesteps)
    return float(np.mean(returns))


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
