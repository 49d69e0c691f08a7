"""Trains a striker to score against a goalkeeper, and writes its policy as ONNX: ``pip install "naoisis[torch]"``, then
``python striker.py --out striker.onnx``.

The policy observes the robot's beliefs. ``learner.py`` has the algorithms: imitation, then PPO.
``naoisis challenge ScoreAgainstKeeper --policy striker.onnx`` measures the policy's success rate.
"""

from __future__ import annotations

import argparse
import csv
import time
from pathlib import Path

import numpy as np
import torch
from learner import Learner, Settings, Worlds
from networks import Sharper
from torch import nn

import naoisis

WORLDS = 256
# The weights of the reward's terms. A goal counts more than all shaping rewards (robot to ball, ball to goal) together.
REWARD = {"success": 2.0, "ball_to_goal": 0.3, "to_ball": 0.2, "time": -0.01}
# The factor of the logits in the exported policy, which draws its choices: a factor above 1 makes the policy less random than in training.
LOGIT_SCALE = 4.0


def learn(task: str, realism: str, steps: int, seed: int, out: Path) -> None:
    """Trains on ``task`` for ``steps`` environment steps, summed over all worlds, and writes the policy ``out``, its layout (.json), and
    its learning curve (.csv)."""
    torch.manual_seed(seed)
    torch.set_num_threads(1)
    worlds = Worlds(task, WORLDS, seed, realism=realism, reward=REWARD)
    settings = Settings(round_steps=16)
    learner = Learner([worlds], seed, settings)
    begun, updates = time.monotonic(), steps // (settings.steps * WORLDS)
    curve: list[tuple[object, ...]] = [("steps", "minutes", "success")]
    learner.imitate()
    for update in range(updates):
        learner.learn(learner.play(), 1 - update / updates, update >= settings.critic_updates)
        if update % 5 == 4 or update == updates - 1:
            minutes, share = (time.monotonic() - begun) / 60, float(np.mean(worlds.successes[-500:] or [0]))
            curve.append(((update + 1) * settings.steps * WORLDS, round(minutes, 2), round(share, 4)))
            print(
                f"{minutes:6.1f} min {curve[-1][0]:>9,} steps {share:6.1%} of the last 500 episodes were a success",
                flush=True,
            )
    player = nn.Sequential(learner.actor, Sharper(LOGIT_SCALE))
    naoisis.export_policy(player, out, worlds.envs, choice="drawn", interactions=learner.interactions)
    with open(out.with_suffix(".csv"), "w", newline="") as file:
        csv.writer(file, lineterminator="\n").writerows(curve)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--task", default="ScoreAgainstKeeper", choices=["ScoreEmptyGoal", "ScoreAgainstKeeper"])
    parser.add_argument("--realism", default="realistic", choices=["paper", "ideal", "realistic"])
    parser.add_argument("--steps", type=int, default=3_000_000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--out", type=Path, default=Path("striker.onnx"))
    learn(**vars(parser.parse_args()))
