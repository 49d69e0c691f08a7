"""Trains a team of three to play matches, and writes its policy as ONNX: ``pip install "naoisis[torch]"``, then
``python team.py --out learned.onnx``.

One policy decides for each robot, from this robot's beliefs alone. ``learner.py`` has the algorithms: imitation, then PPO, in some worlds
by self-play, in the others against built-in teams. ``naoisis batch match3v3 --pairs policy:learned.onnx,roles`` measures the policy's
results.
"""

from __future__ import annotations

import argparse
import csv
import time
from pathlib import Path

import torch
from learner import Learner, Settings, Worlds

import naoisis

# The number of worlds of self-play and of worlds against built-in teams, and these teams.
SELF_PLAY, BUILT_IN, OPPONENTS = 24, 40, ["roles", "passers"]
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
    worlds = [
        Worlds("match3v3", SELF_PLAY, seed, control=["blue", "pink"], **same),
        Worlds("match3v3", BUILT_IN, seed + 1_000_000, control=["blue"], opponents=OPPONENTS, **same),
    ]
    imitation = {"rounds": 120, "round_steps": 32, "round_updates": 150, "round_minibatch": 1024, "logit_scale": 3.0}
    settings = Settings(**imitation, steps=256, epochs=2, rate=1e-4, entropy=0.0, clip=0.1, critic_updates=6)
    learner = Learner(worlds, seed, settings)
    begun, updates = time.monotonic(), steps // (settings.steps * sum(len(of.observations) for of in worlds))
    curve: list[tuple[object, ...]] = [("steps", "minutes", "goals", "goals against")]

    def write() -> None:
        note = "learned by python/examples/ppo/team.py"
        naoisis.export_policy(
            learner.actor, out, worlds[1].envs, choice="drawn", interactions=learner.interactions, note=note
        )
        with open(out.with_suffix(".csv"), "w", newline="") as file:
            csv.writer(file, lineterminator="\n").writerows(curve)

    learner.imitate()
    write()
    for update in range(updates):
        batch = learner.play()
        learner.learn(batch, 1 - update / updates, update >= settings.critic_updates)
        if update % 10 == 9 or update == updates - 1:
            minutes, goals = (time.monotonic() - begun) / 60, worlds[1].goals_per_match(MATCH_STEPS)
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
