"""How much two teams miss the messages that are lost: a sweep on all machines that Ray knows. ``python sweep.py [matches]``.

On a machine of its own, Ray begins with its cores; ``RAY_ADDRESS`` names a cluster. Ctrl-C leaves the rows that are finished in the table,
and the same command goes on from there.
"""

from __future__ import annotations

import argparse

import naoisis.cluster

SWEEP = {"messages.loss": [0.0, 0.5, 1.0]}


def main(matches: int = 100, duration_s: float | None = None, csv: str | None = None) -> list[dict]:
    """Plays so many matches with each value. What each comes to."""
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
    parser.add_argument("matches", type=int, nargs="?", default=100, help="of each combination")
    parser.add_argument("--duration-s", type=float, help="where each match stops [default: the final whistle]")
    parser.add_argument("--csv", help="the table, to be gone on with")
    main(**vars(parser.parse_args()))
