#!/usr/bin/env python3
"""Compares what two commits cost.

    python3 benches/compare.py BEFORE.json AFTER.json [--most PERCENT]

The files are those of `benches/table.sh --json`. Prints both, and exits with 1 if the instructions of a cycle in one of
the matches have become more by PERCENT [2] or more. Times are printed only: they depend on what else the machine does.
"""

import argparse
import json
import sys


def read(path):
    with open(path, encoding="utf-8") as file:
        return json.load(file)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("before")
    parser.add_argument("after")
    parser.add_argument("--most", type=float, default=2.0, metavar="PERCENT")
    options = parser.parse_args()
    before, after = read(options.before), read(options.after)
    if before["machine"] != after["machine"]:
        sys.exit(f"{before['machine']} and {after['machine']}: instructions of different processors are not compared")
    print(f"{'instructions a cycle':<52} {before['commit']:>16} {after['commit']:>16}")
    worse = []
    old, new = before["instructions_a_cycle"], after["instructions_a_cycle"]
    for name in [name for name in old if name in new]:
        change = 100 * (new[name] / old[name] - 1)
        print(f"{name:<52} {old[name]:>16,} {new[name]:>16,} {change:+7.2f} %")
        if change >= options.most:
            worse.append(name)
    print()
    for name in [name for name in before["table"] if name in after["table"]]:
        print(f"{name:<52} {before['table'][name]:>28} {after['table'][name]:>28}")
    if worse:
        sys.exit(f"{options.most} % more instructions, or more than that: {', '.join(worse)}")


if __name__ == "__main__":
    main()
