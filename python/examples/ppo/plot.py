"""Plots the learning curves in the folder ``policies``: ``python plot.py`` writes ``curves.png`` and ``self_play.png``."""

from __future__ import annotations

import csv
from pathlib import Path

import matplotlib
from team_policy import Record

matplotlib.use("agg")
from matplotlib import pyplot

FOLDER = Path(__file__).parent


def rows_of(path: Path) -> list[dict[str, float]]:
    """Returns the rows of the learning curve in the file ``path``."""
    with open(path, newline="") as file:
        return [{name: float(cell) for name, cell in row.items()} for row in csv.DictReader(file)]


def plot_tasks(paths: list[Path]) -> None:
    """Plots the success rates of single robots over the steps of training, one curve for each file in ``paths``, and writes
    ``curves.png``."""
    figure, plot = pyplot.subplots(figsize=(7, 3.2), constrained_layout=True)
    for path in paths:
        rows = rows_of(path)
        task, observation = path.stem.split("-")
        minutes = rows[-1]["minutes"]
        label = f"{task}, {observation} ({minutes:.0f} min)"
        plot.plot([row["steps"] / 1e6 for row in rows], [100 * row["success"] for row in rows], label=label)
    plot.set(xlabel="steps of all worlds, millions", ylabel="success, % of 400 episodes", ylim=(0, 100), xlim=(0, None))
    plot.grid(alpha=0.3)
    plot.legend(loc="lower right")
    figure.savefig(FOLDER / "curves.png", dpi=110)


def plot_self_play(path: Path) -> None:
    """Plots how often the team trained by self-play wins against ``chasers``, a team that takes no part in training, and writes
    ``self_play.png``."""
    rows = rows_of(path)
    steps = [row["steps"] / 1e6 for row in rows]
    records = [Record(*(int(row[name]) for name in ("won", "lost", "undecided"))) for row in rows]
    low, high = zip(*(record.interval for record in records))
    figure, plot = pyplot.subplots(figsize=(7, 3.2), constrained_layout=True)
    plot.plot(steps, [100 * record.share for record in records], marker=".", label="won, of those that are decided")
    plot.fill_between(
        steps, [100 * share for share in low], [100 * share for share in high], alpha=0.2, label="95 % interval"
    )
    undecided = [100 * record.undecided / (record.won + record.lost + record.undecided) for record in records]
    plot.plot(steps, undecided, color="grey", linestyle="--", label="undecided, of all")
    plot.axhline(50, color="black", linewidth=0.8)
    plot.set(
        xlabel="steps of all robots that learn, millions",
        ylabel="% of 100 episodes against chasers",
        ylim=(0, 100),
        xlim=(0, None),
    )
    plot.grid(alpha=0.3)
    plot.legend(loc="upper left", ncols=3, fontsize="small")
    figure.savefig(FOLDER / "self_play.png", dpi=110)


if __name__ == "__main__":
    plot_tasks(sorted((FOLDER / "policies").glob("ScoreEmptyGoal-*.csv")))
    plot_self_play(FOLDER / "policies" / "FirstGoal-belief.csv")
