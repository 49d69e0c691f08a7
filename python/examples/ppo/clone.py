"""Trains a policy by behaviour cloning, from demonstrations alone, and writes it as ONNX: ``pip install "naoisis[torch]" minari pyarrow
pillow``, then ``python clone.py datasets --out clone.onnx``.

``naoisis episodes --team passers --out datasets`` writes the demonstrations. One policy decides for each robot, from this robot's beliefs.
Its actions are ``velocities``; each demonstrated action is replaced by the nearest choices, and training maximises their likelihood.
"""

from __future__ import annotations

import argparse
import csv
import os
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import torch
from adviser import SHARES
from networks import Sharper, actor
from torch import nn

import naoisis

# The minibatch size and the initial learning rate.
MINIBATCH, RATE = 4096, 1e-3
# One in this many episodes is held out of training, to measure the loss.
HELD_OUT = 20
# The factor of the logits with which the policy plays: less random than maximum likelihood.
LOGIT_SCALE = 4.0
# Observations that tell the last action. A clone that observes them learns to repeat itself.
LAST_ACTION = ("step.x", "step.y", "step.turn", "body.walking", "body.kicking")
# The distance to the ball below which a decision counts as near the ball, m. Half of each minibatch are such decisions: they are difficult.
NEAR_M = 0.5


class Without(nn.Module):
    """Sets the columns ``hidden`` of observations with the columns ``names`` to 0."""

    def __init__(self, names: Sequence[str], hidden: Sequence[str]):
        super().__init__()
        self.register_buffer("kept", torch.tensor([[float(name not in hidden) for name in names]]))

    def forward(self, observations: torch.Tensor) -> torch.Tensor:
        return observations * self.kept


def columns_for(names: list[str], dataset: Any) -> np.ndarray:
    """Returns the index of each name among the observation's columns in ``dataset``, or -1 for a robot that its matches do not have."""
    columns = {name: index for index, name in enumerate(dataset.storage.metadata["naoisis"]["observation_names"])}
    return np.array([columns.get(name, -1) for name in names])


def choices(actions: np.ndarray) -> np.ndarray:
    """Returns the choices of ``velocities`` that are nearest to ``actions``, which are ``continuous``: shape (rows, 4)."""
    walk = np.abs(actions[:, :3, None] - SHARES).argmin(axis=2)
    is_right, is_side = actions[:, 6] < 0, actions[:, 7] > 0
    kick = np.where(actions[:, 5] > 0.5, 1 + is_right + 2 * is_side, 0)
    return np.column_stack([walk, kick]).astype(np.int64)


def read(names: list[str], most: int) -> tuple[list[np.ndarray], list[np.ndarray]]:
    """Returns the observations and the choices of each episode of all data sets. Reads whole episodes of a data set until there
    are more than ``most`` rows. Columns that a data set does not have are 0: the robot is unknown."""
    import minari

    observed, chosen = [], []
    for name in sorted(minari.list_local_datasets()):
        dataset, rows = minari.load_dataset(name), 0
        columns = columns_for(names, dataset)
        for episode in dataset.iterate_episodes():
            seen = episode.observations[:-1]
            observed.append(np.where(columns < 0, 0, seen[:, columns]).astype(np.float32))
            chosen.append(choices(episode.actions))
            rows += len(seen)
            if rows > most:
                break
        print(f"{name}: {rows:,} rows", flush=True)
    return observed, chosen


def learn(datasets: Path, rows: int, updates: int, seed: int, out: Path) -> None:
    """Trains in ``updates`` minibatches on all data sets in the folder ``datasets``, at most about ``rows`` rows of each, and writes the policy
    ``out``, its layout (.json), and its learning curve (.csv)."""
    torch.manual_seed(seed)
    torch.set_num_threads(1)
    os.environ["MINARI_DATASETS_PATH"] = str(datasets.resolve())
    # The policy has the observation of a match of three against three. In larger matches, the observation has the nearest robots.
    env = naoisis.vector_env("match3v3", 1, control=["blue"], observation="belief", action="velocities")
    names, sizes = list(env.observation_names), [int(size) for size in env.single_action_space.nvec]
    observed, chosen = read(names, rows)
    parts = []
    for is_held_out in (False, True):
        episodes = [index for index in range(len(observed)) if (index % HELD_OUT == 0) == is_held_out]
        parts.append([torch.from_numpy(np.concatenate([of[index] for index in episodes])) for of in (observed, chosen)])
    (seen, decided), (test_seen, test_decided) = parts
    ball = seen[:, [names.index(f"ball.{name}") for name in ("known", "x", "y")]]
    near = torch.nonzero((ball[:, 0] > 0.5) & (torch.hypot(ball[:, 1], ball[:, 2]) < NEAR_M)).squeeze(1)
    policy = nn.Sequential(Without(names, LAST_ACTION), actor(names, sum(sizes)))
    optimiser = torch.optim.Adam(policy.parameters(), RATE)

    def losses(seen: torch.Tensor, decided: torch.Tensor) -> torch.Tensor:
        """Returns the mean negative log-likelihood of each of the four choices."""
        logits = policy(seen).split(sizes, -1)
        return torch.stack([nn.functional.cross_entropy(of, decided[:, index]) for index, of in enumerate(logits)])

    curve: list[tuple[object, ...]] = [("updates", "minutes", "loss", "loss in held-out episodes")]
    begun = time.monotonic()
    for update in range(updates):
        optimiser.param_groups[0]["lr"] = RATE * (1 - update / updates) + 1e-5
        batch = torch.randint(len(seen), (MINIBATCH,))
        batch[: MINIBATCH // 2] = near[torch.randint(len(near), (MINIBATCH // 2,))]
        loss = losses(seen[batch], decided[batch]).sum()
        optimiser.zero_grad()
        loss.backward()
        optimiser.step()
        if update % 500 == 499 or update == updates - 1:
            with torch.no_grad():
                held_out = float(losses(test_seen[:50_000], test_decided[:50_000]).sum())
            minutes = (time.monotonic() - begun) / 60
            curve.append((update + 1, round(minutes, 2), round(float(loss), 4), round(held_out, 4)))
            print(
                f"{minutes:6.1f} min {update + 1:>7,} updates, loss {loss:.3f}, held-out loss {held_out:.3f}",
                flush=True,
            )
    player = nn.Sequential(policy, Sharper(LOGIT_SCALE))
    note = "learned by python/examples/ppo/clone.py"
    naoisis.export_policy(player, out, env, choice="drawn", interactions=len(seen), note=note)
    with open(out.with_suffix(".csv"), "w", newline="") as file:
        csv.writer(file, lineterminator="\n").writerows(curve)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("datasets", type=Path, help="the folder of Minari data sets, as in MINARI_DATASETS_PATH")
    parser.add_argument(
        "--rows",
        type=int,
        default=200_000,
        help="the number of rows of each data set, rounded up to whole episodes [%(default)s]",
    )
    parser.add_argument("--updates", type=int, default=6000, help="the number of minibatches [%(default)s]")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--out", type=Path, default=Path("clone.onnx"))
    learn(**vars(parser.parse_args()))
