"""Two robots learn to play two others, by playing against themselves: ``python self_play.py``.

One policy decides for all four robots. It is told what a behaviour by hand would do, and leans towards that a little: an eighth of its steps
are those at first, and it loses against everybody. What the advice is worth, and when, it has to learn. In most worlds it plays against itself
as it is, and learns from both sides; in the others against itself as it was earlier. It never learns against a built-in team: those are who
it is measured with. ``python self_play.py --play 1000`` only measures.
"""

from __future__ import annotations

import argparse
import csv
import os
import time
from pathlib import Path

# Small matrices are slower on many threads. Before NumPy is there.
os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np
import torch
from adviser import Adviser
from team_learning import Settings, TeamLearner
from team_policy import TeamPolicy, play

import naoisis

TASK = "FirstGoal"
# A goal is worth more than all of the rest: being near the ball, and having it near the opponents' goal.
REWARD = {"score": 3.0, "ball_to_goal": 0.5, "to_ball": 0.1}
# Worlds, and those of them in which the policy plays against itself as it is.
WORLDS, MIRRORED = 64, 48
# Every so many updates the policy joins the pool of opponents, of which the latest so many stay.
EVERY, POOL = 10, 40
# It is measured so often as it learns, in so many episodes. Those who learn have other seeds, and the test in the end has others again.
MEASURED, EPISODES, SEED_OF_CURVE, SEED_OF_TEST = 16, 100, 500_000, 1_000_000
FOLDER = Path(__file__).parent / "policies"


def learn(steps: int, seed: int, out: Path) -> None:
    """Learns for so many steps of all robots that learn, and writes the policy and the curve."""
    begun = time.monotonic()
    torch.manual_seed(seed)
    torch.set_num_threads(1)
    envs = naoisis.vector_env(
        TASK,
        WORLDS,
        control=["blue", "pink"],
        observation="belief",
        action="velocities",
        reward=REWARD,
        autoreset_mode="same_step",
        threads=1,
    )
    learner = TeamLearner(envs, seed, MIRRORED, Settings())
    learner.remember(POOL)
    path = out / f"{TASK}-belief"
    curve: list[tuple[object, ...]] = [("steps", "minutes", "won", "lost", "undecided")]
    updates = -(-steps // learner.samples)
    decided: list[bool] = []
    for update in range(updates + 1):
        if update * MEASURED // updates != (update - 1) * MEASURED // updates:
            learner.save(path.with_suffix(".npz"))
            policy = TeamPolicy(path.with_suffix(".npz"), envs.observation_names)
            record = play(TASK, policy, "chasers", EPISODES, SEED_OF_CURVE)
            minutes = (time.monotonic() - begun) / 60
            curve.append((update * learner.samples, round(minutes, 2), record.won, record.lost, record.undecided))
            share = np.mean(decided[-1000:] or [0])
            print(
                f"{minutes:6.1f} min {curve[-1][0]:>10,} steps, {share:.0%} decided of late; against chasers {record}",
                flush=True,
            )
            with open(path.with_suffix(".csv"), "w", newline="") as file:
                csv.writer(file, lineterminator="\n").writerows(curve)
            if update == updates:
                break
        decided += learner.play()
        # Ever more slowly.
        learner.learn(1 - update / updates)
        if update % EVERY == EVERY - 1:
            learner.remember(POOL)


def measure(episodes: int, path: Path) -> None:
    """Prints what comes of so many other episodes against each of the built-in teams, with the policy and with the advice alone."""
    names = naoisis.MatchEnv(TASK, observation="belief").observation_names
    for team in ("chasers", "roles"):
        for player, policy in (("the policy", TeamPolicy(path, names)), ("the advice alone", Adviser(names))):
            print(f"{player} against {team}: {play(TASK, policy, team, episodes, SEED_OF_TEST)}", flush=True)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--steps", type=int, default=12_000_000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--out", type=Path, default=FOLDER)
    parser.add_argument(
        "--play", type=int, metavar="EPISODES", help="learn nothing: measure the policy that is in the folder"
    )
    given = parser.parse_args()
    if given.steps < 1 or (given.play is not None and given.play < 1):
        parser.error("there must be a step to learn from, and an episode to measure")
    if given.play is None:
        learn(given.steps, given.seed, given.out)
    measure(given.play or 1000, given.out / f"{TASK}-belief.npz")
