"""Draws the learning curves of the folder ``policies``: ``python plot.py`` writes ``curves.png``."""

from __future__ import annotations

import csv
from pathlib import Path

import matplotlib

matplotlib.use("agg")
from matplotlib import pyplot  # noqa: E402

FOLDER = Path(__file__).parent


def main() -> None:
    figure, plot = pyplot.subplots(figsize=(7, 3.2), constrained_layout=True)
    for path in sorted((FOLDER / "policies").glob("*.csv")):
        with open(path, newline="") as file:
            rows = [{name: float(cell) for name, cell in row.items()} for row in csv.DictReader(file)]
        task, observation = path.stem.split("-")
        minutes = rows[-1]["minutes"]
        label = f"{task}, {observation} ({minutes:.0f} min)"
        plot.plot([row["steps"] / 1e6 for row in rows], [100 * row["success"] for row in rows], label=label)
    plot.set(xlabel="steps of all worlds, millions", ylabel="success, % of 400 episodes", ylim=(0, 100), xlim=(0, None))
    plot.grid(alpha=0.3)
    plot.legend(loc="lower right")
    figure.savefig(FOLDER / "curves.png", dpi=110)


if __name__ == "__main__":
    main()
