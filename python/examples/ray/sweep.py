"""Measures the effect of lost messages on the results of a match, in a sweep on all machines of Ray's cluster:
``python sweep.py [matches]``.

``RAY_ADDRESS`` names the cluster; without it, Ray uses the cores of this machine. After Ctrl-C the finished rows are in the table
``--csv``, and the same command continues from there.
"""

from __future__ import annotations

import argparse

import naoisis.cluster

SWEEP = {"messages.loss": [0.0, 0.5, 1.0]}


def main(matches: int = 100, duration_s: float | None = None, csv: str | None = None) -> list[dict]:
    """Plays ``matches`` matches with each value of ``SWEEP``, and returns a summary of each."""
    table = naoisis.cluster.batch(
        "match3v3", matches, seed=1, pink="passers", sweep=SWEEP, duration_s=duration_s, csv=csv
    )
    found = table.summary()
    for row in found:
        wins = row["blue_wins"]
        print(
            f"{row['settings']}: blue wins {wins['value']:.1%} ({wins['low']:.1%} to {wins['high']:.1%}) of {row['matches']}"
        )
    return found


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "matches", type=int, nargs="?", default=100, help="the number of matches for each value [%(default)s]"
    )
    parser.add_argument("--duration-s", type=float, help="the duration of a match, s [default: to the final whistle]")
    parser.add_argument("--csv", help="the file of the table; if it has rows already, the sweep continues after them")
    main(**vars(parser.parse_args()))
