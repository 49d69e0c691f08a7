"""Trains a team of two by self-play: ``python self_play.py``.

All four robots share one policy. Its observation includes the action that a hand-written behaviour (``adviser.py``) advises, and a constant
is added to the logits of this action, so that the untrained policy takes the whole advised action in an eighth of its steps. The untrained
policy hardly ever wins: it has to learn when the advice is good. In most worlds the current policy plays both teams, and learns from both;
in the others an earlier policy from the opponent pool plays pink. Built-in teams take no part in training: they are the opponents of the
tests. ``python self_play.py --play 1000`` tests the saved policy without training.
"""

from __future__ import annotations

import argparse
import csv
import os
import time
from pathlib import Path

# Products of small matrices are slower on many threads. NumPy reads this variable when it is imported.
os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np
import torch
from adviser import Adviser
from team_learning import Settings, TeamLearner
from team_policy import TeamPolicy, play

import naoisis

TASK = "FirstGoal"
# The weights of the reward's terms. A goal counts more than all shaping rewards (robot to ball, ball to goal) together.
REWARD = {"score": 3.0, "ball_to_goal": 0.5, "to_ball": 0.1}
# The number of worlds, and of those in which the current policy plays both teams.
WORLDS, MIRRORED = 64, 48
# The number of updates between two additions to the opponent pool, and the most policies in it.
EVERY, POOL = 10, 40
# The number of tests during training, the episodes of each, and the first seeds of these tests and of the final one: both differ from the
# seeds of training.
MEASURED, EPISODES, SEED_OF_CURVE, SEED_OF_TEST = 16, 100, 500_000, 1_000_000
FOLDER = Path(__file__).parent / "policies"


def learn(steps: int, seed: int, out: Path) -> None:
    """Trains for ``steps`` environment steps, summed over all learning robots, and writes the policy and its learning curve to ``out``."""
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
    learner.add_to_pool(POOL)
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
                f"{minutes:6.1f} min {curve[-1][0]:>10,} steps, {share:.0%} of recent episodes decided by a goal; against chasers {record}",
                flush=True,
            )
            with open(path.with_suffix(".csv"), "w", newline="") as file:
                csv.writer(file, lineterminator="\n").writerows(curve)
            if update == updates:
                break
        decided += learner.play()
        # The learning rate falls linearly to 0.
        learner.learn(1 - update / updates)
        if update % EVERY == EVERY - 1:
            learner.add_to_pool(POOL)


def measure(episodes: int, path: Path) -> None:
    """Prints results against two built-in teams, in ``episodes`` test episodes each: for the policy of the file ``path``, and for robots
    that always follow the adviser."""
    names = naoisis.MatchEnv(TASK, observation="belief").observation_names
    for team in ("chasers", "roles"):
        for player, policy in (("the policy", TeamPolicy(path, names)), ("the adviser", Adviser(names))):
            print(f"{player} against {team}: {play(TASK, policy, team, episodes, SEED_OF_TEST)}", flush=True)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--steps", type=int, default=12_000_000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--out", type=Path, default=FOLDER)
    parser.add_argument(
        "--play",
        type=int,
        metavar="EPISODES",
        help="only test the policy in the folder OUT, in EPISODES episodes against each team",
    )
    given = parser.parse_args()
    if given.steps < 1 or (given.play is not None and given.play < 1):
        parser.error("--steps and --play: expected at least 1")
    if given.play is None:
        learn(given.steps, given.seed, given.out)
    measure(given.play or 1000, given.out / f"{TASK}-belief.npz")
