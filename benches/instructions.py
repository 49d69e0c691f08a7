"""Counts the processor instructions of a decision cycle in some matches, by valgrind.

    python3 benches/instructions.py PROGRAM [--json FILE] [--table FILE]

PROGRAM is the built `naoisis`. A match is played twice, the second time for longer: the difference is what its further
cycles cost, without the start. The same program gives the same counts on a busy machine, too, but for some in 100,000.
`--json` writes them, with the lines of the file of `--table`.
"""

import argparse
import json
import platform
import re
import subprocess

# What is counted, and the arguments of `naoisis run`, with the shorter and the longer time, s.
MATCHES = {
    "match3v3": (["match3v3"], 5, 25),
    "match3v3 with trace": (["match3v3", "--trace", "/dev/null", "--force"], 5, 15),
    "match3v3, realistic": (["match3v3", "--realism", "realistic"], 5, 25),
    "match7v7": (["match7v7"], 5, 15),
    "hsl2026_middle": (["hsl2026_middle"], 5, 15),
    "match3v3_images": (["match3v3_images"], 0.5, 1.5),
}
# Of the built-in scenarios.
CYCLE_S = 1 / 30


def instructions(program, arguments, duration_s):
    """How many instructions a match takes."""
    command = ["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null", program, "run", *arguments]
    command += ["--seed", "1", "--duration", str(duration_s), "--quiet"]
    run = subprocess.run(command, capture_output=True, text=True, check=False)
    counted = re.search(r"Collected\s*:\s*(\d+)", run.stderr)
    if run.returncode != 0 or counted is None:
        raise SystemExit(f"{' '.join(command)}\n{run.stderr}")
    return int(counted[1])


def commit():
    """The commit that is checked out, with a + if files differ from it."""
    described = subprocess.run(["git", "describe", "--always", "--dirty=+"], capture_output=True, text=True, check=False)
    return described.stdout.strip()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("--json")
    parser.add_argument("--table")
    options = parser.parse_args()
    counts = {}
    for name, (arguments, shorter_s, longer_s) in MATCHES.items():
        short, long = (instructions(options.program, arguments, time_s) for time_s in (shorter_s, longer_s))
        counts[name] = round((long - short) / ((longer_s - shorter_s) / CYCLE_S))
        print(f"{name:<52} {counts[name]:,} instructions a cycle", flush=True)
    if options.json:
        table = {}
        if options.table:
            with open(options.table, encoding="utf-8") as lines:
                table = dict(re.split(r"\s{2,}", line.strip(), maxsplit=1) for line in lines if "  " in line.strip())
        with open(options.json, "w", encoding="utf-8") as file:
            written = {"commit": commit(), "machine": platform.machine(), "instructions_a_cycle": counts, "table": table}
            json.dump(written, file, indent=2)
            file.write("\n")


if __name__ == "__main__":
    main()
