#!/usr/bin/env bash
# Prints one table of what everything costs, with the real-time factors, and how well image vision sees:
#
#     benches/table.sh [--json FILE] [--instructions [--program FILE]]
#
# It takes a quarter of an hour, on a machine that should have nothing else to do. `--json` counts the instructions of some
# matches, too (needs valgrind), and writes them with the table: `benches/compare.py` compares two such files. With
# `--instructions` only they are counted, which takes minutes and which other programs do not disturb; `--program` counts
# those of a `naoisis` that is built already.
set -euo pipefail
cd "$(dirname "$0")/.."
json='' only_instructions='' program=''
while [ $# -gt 0 ]; do
    case "$1" in
        --json) json=$2; shift 2 ;;
        --program) program=$2; shift 2 ;;
        --instructions) only_instructions=yes; shift ;;
        *) sed -n '2,9s/^# \{0,1\}//p' "$0" >&2; exit 2 ;;
    esac
done
# Built as the programs of a release are.
export CARGO_INCREMENTAL=0
table=$(mktemp)
trap 'rm -f "$table"' EXIT

if [ -z "$only_instructions" ]; then
    benchmarks=(--bench parts --bench sensors --bench cameras --bench wire --bench cycle)
    # Building is not part of it.
    cargo bench --quiet --no-default-features "${benchmarks[@]}" --bench vision --no-run >&2
    # A figure is a line, what it is of before the colon. Criterion's have their name before, or in a line of its own.
    cargo bench --quiet --no-default-features "${benchmarks[@]}" | awk '
        function figure(name, value) { printf "%-52s %s\n", name, value; fflush() }
        /^Benchmarking |^ +(change|slope|mean|thrpt)|^Found / { next }
        / time: +\[/ {
            split($0, sides, / time: +\[/); sub(/ +$/, "", sides[1]); split(sides[2], values, " ")
            figure(sides[1] == "" ? name : sides[1], values[3] " " values[4]); next
        }
        / time: +\[/ == 0 && index($0, ": ") { at = index($0, ": "); figure(substr($0, 1, at - 1), substr($0, at + 2)); next }
        NF { name = $0 }' | tee "$table"
    echo
    cargo bench --quiet --no-default-features --bench vision
fi
if [ -n "$json$only_instructions" ]; then
    if [ -z "$program" ]; then
        cargo build --quiet --release --no-default-features
        program=${CARGO_TARGET_DIR:-target}/release/naoisis
    fi
    python3 benches/instructions.py "$program" --table "$table" ${json:+--json "$json"}
fi
