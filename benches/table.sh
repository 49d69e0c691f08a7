#!/usr/bin/env bash
# Runs the benchmarks and prints one table of what everything costs, with the real-time factors; then how well image
# vision sees. It takes a few minutes, on a machine that should have nothing else to do.
set -euo pipefail
cd "$(dirname "$0")/.."
benchmarks=(--bench parts --bench sensors --bench cameras --bench wire)
# Building is not part of it.
cargo bench --quiet --no-default-features "${benchmarks[@]}" --bench vision --no-run >&2
# Every figure is a line, what it is of before the colon.
cargo bench --quiet --no-default-features "${benchmarks[@]}" | awk -F': ' 'NF > 1 { printf "%-52s %s\n", $1, $2; fflush() }'
echo
cargo bench --quiet --no-default-features --bench vision
