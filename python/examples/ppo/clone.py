"""A player learns from demonstrations alone to play as the team that gave them, and is written as ONNX: ``pip install "naoisis[torch]"
"minari[arrow]"``, then ``python clone.py datasets --out clone.onnx``.

``naoisis episodes --team passers --out datasets`` writes the demonstrations. One network decides for each robot by what this robot
believes: it learns by maximum likelihood which of the choices of the action ``velocities`` is nearest to the demonstrated one.
"""

from __future__ import annotations

import argparse
import csv
import os
import time
from pathlib import Path
from typing import Any

import numpy as np
import torch
from adviser import SHARES
from networks import actor

import naoisis

# Rows in an update, and the learning rate at first.
ROWS, RATE = 4096, 1e-3
# One episode of this many is kept to measure what was learned.
HELD_OUT = 20
# Half of the rows in an update are of robots that are nearer to the ball than this, where decisions are difficult, m.
NEAR_M = 0.5


def observations_for(names: list[str], dataset: Any) -> np.ndarray:
    """The column of each name in the observations of ``dataset``, or -1: a robot that its match lacks is unknown."""
    columns = {name: index for index, name in enumerate(dataset.storage.metadata["naoisis"]["observation_names"])}
    return np.array([columns.get(name, -1) for name in names])


def choices(actions: np.ndarray) -> np.ndarray:
    """The choices of ``velocities`` that are nearest to continuous ``actions``, one row each."""
    walk = np.abs(actions[:, :3, None] - SHARES).argmin(axis=2)
    is_right, is_side = actions[:, 6] < 0, actions[:, 7] > 0
    kick = np.where(actions[:, 5] > 0.5, 1 + is_right + 2 * is_side, 0)
    return np.column_stack([walk, kick]).astype(np.int64)


def read(names: list[str], most: int) -> tuple[list[np.ndarray], list[np.ndarray]]:
    """Observations and choices of each episode, at most ``most`` rows of each data set."""
    import minari

    observed, chosen = [], []
    for name in sorted(minari.list_local_datasets()):
        dataset, rows = minari.load_dataset(name), 0
        columns = observations_for(names, dataset)
        for episode in dataset.iterate_episodes():
            seen = episode.observations[:-1]
            observed.append(np.where(columns < 0, 0, seen[:, columns]).astype(np.float32))
            chosen.append(choices(episode.actions))
            rows += len(seen)
            if rows > most:
                break
        print(f"{name}: {rows:,} rows", flush=True)
    return observed, chosen


def learn(datasets: Path, rows: int, minutes: float, seed: int, out: Path) -> None:
    """Learns from all data sets of a folder for some minutes, and writes the policy, its layout, and the curve."""
    torch.manual_seed(seed)
    torch.set_num_threads(1)
    os.environ["MINARI_DATASETS_PATH"] = str(datasets.resolve())
    # The observation of a match of three against three: in other matches the nearest robots are in it.
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
    choice = actor(names, sum(sizes))
    optimiser = torch.optim.Adam(choice.parameters(), RATE)

    def losses(seen: torch.Tensor, decided: torch.Tensor) -> torch.Tensor:
        """The mean negative log-likelihood of each of the four choices."""
        scores = choice(seen).split(sizes, -1)
        return torch.stack([torch.nn.functional.cross_entropy(of, decided[:, list_]) for list_, of in enumerate(scores)])

    curve: list[tuple[object, ...]] = [("minutes", "updates", "loss", "loss in held-out episodes")]
    begun, updates, shown = time.monotonic(), 0, 0.0
    while (share := (time.monotonic() - begun) / (60 * minutes)) < 1:
        optimiser.param_groups[0]["lr"] = RATE * (1 - share) + 1e-5
        batch = torch.randint(len(seen), (ROWS,))
        batch[: ROWS // 2] = near[torch.randint(len(near), (ROWS // 2,))]
        loss = losses(seen[batch], decided[batch]).sum()
        optimiser.zero_grad()
        loss.backward()
        optimiser.step()
        updates += 1
        if share > shown:
            shown += 0.1
            with torch.no_grad():
                held_out = float(losses(test_seen[:50_000], test_decided[:50_000]).sum())
            curve.append((round(share * minutes, 2), updates, round(float(loss), 4), round(held_out, 4)))
            print(f"{share * minutes:6.1f} min {updates:>7,} updates, loss {loss:.3f}, held out {held_out:.3f}", flush=True)
    naoisis.export_policy(choice, out, env, choice="drawn", note="learned by python/examples/ppo/clone.py")
    with open(out.with_suffix(".csv"), "w", newline="") as file:
        csv.writer(file, lineterminator="\n").writerows(curve)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("datasets", type=Path, help="the folder of data sets, as in MINARI_DATASETS_PATH")
    parser.add_argument("--rows", type=int, default=200_000, help="the most rows of each data set [%(default)s]")
    parser.add_argument("--minutes", type=float, default=10.0, help="how long it learns [%(default)s]")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--out", type=Path, default=Path("clone.onnx"))
    learn(**vars(parser.parse_args()))
