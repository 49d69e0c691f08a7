"""Trains a team of three to play matches, and writes its policy as ONNX: ``pip install "naoisis[torch]"``, then
``python team.py --out learned.onnx``.

One policy decides for each robot, from this robot's beliefs alone. ``learner.py`` has the algorithms: imitation, then PPO, both by self-play:
the policy plays both teams. Built-in teams take no part in training: they are the opponents of the tests.
``naoisis batch match3v3 --pairs policy:learned.onnx,roles`` measures the policy's results.
"""

from __future__ import annotations

import argparse
import csv
import time
from pathlib import Path

import torch
from learner import Learner, Settings, Worlds

import naoisis

# The number of worlds.
WORLDS = 44
# The opponents of a test, its number of worlds, and the number of steps of each: together a match.
OPPONENTS, TESTED, TEST_STEPS = ["roles", "passers"], 20, 600
# The weights of the reward's terms. A goal counts more than the ball's whole way to the goal.
REWARD = {"score": 2.0, "ball_to_goal": 0.3}
# Steps of a match of 20 minutes.
MATCH_STEPS = 12_000


def learn(realism: str, steps: int, seed: int, out: Path) -> None:
    """Trains for ``steps`` environment steps, summed over all learning robots, and writes the policy ``out``, its layout (.json), and its
    learning curve (.csv)."""
    torch.manual_seed(seed)
    torch.set_num_threads(1)
    same = {"realism": realism, "reward": REWARD}
    worlds = Worlds("match3v3", WORLDS, seed, control=["blue", "pink"], **same)
    tests = Worlds("match3v3", TESTED, seed + 1_000_000, control=["blue"], opponents=OPPONENTS, **same)
    imitation = {"rounds": 120, "round_steps": 32, "round_updates": 150, "round_minibatch": 1024, "logit_scale": 3.0}
    settings = Settings(**imitation, steps=256, epochs=2, rate=1e-4, entropy=0.0, clip=0.1, critic_updates=6)
    learner = Learner([worlds], seed, settings)
    begun, updates = time.monotonic(), steps // (settings.steps * len(worlds.observations))
    curve: list[tuple[object, ...]] = [("steps", "minutes", "goals", "goals against")]

    def write() -> None:
        note = "learned by python/examples/ppo/team.py"
        naoisis.export_policy(
            learner.actor, out, tests.envs, choice="drawn", interactions=learner.interactions, note=note
        )
        with open(out.with_suffix(".csv"), "w", newline="") as file:
            csv.writer(file, lineterminator="\n").writerows(curve)

    learner.imitate()
    write()
    for update in range(updates):
        batch = learner.play()
        learner.learn(batch, 1 - update / updates, update >= settings.critic_updates)
        if update % 10 == 9 or update == updates - 1:
            for _ in range(TEST_STEPS):
                tests.step(learner.act(tests.observations))
            minutes, goals = (time.monotonic() - begun) / 60, tests.goals_per_match(MATCH_STEPS)
            done = (update + 1) * len(batch["observation"])
            curve.append((done, round(minutes, 2), *goals.round(2)))
            print(
                f"{minutes:6.1f} min {done:>11,} steps, goals against built-in teams in 20 min: {goals[0]:.2f} : {goals[1]:.2f}",
                flush=True,
            )
            write()


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--realism", default="realistic", choices=["paper", "ideal", "realistic"])
    parser.add_argument("--steps", type=int, default=3_000_000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--out", type=Path, default=Path("learned.onnx"))
    learn(**vars(parser.parse_args()))
