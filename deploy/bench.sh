#!/usr/bin/env bash
# Benchmarks: `crumple bench` with its table and JSON, then single kernels by criterion, then the
# cost of the order of nodal sums. Run it on an idle machine.
#
#   deploy/bench.sh             writes out/bench/RESULTS.md and out/bench/bench.json
#   deploy/bench.sh --only tube passes its arguments to `crumple bench`, without single kernels
set -euo pipefail

if [[ ${1:-} == -h || ${1:-} == --help ]]; then
    sed -n '2,6s/^# \{0,1\}//p' "$0"
    exit 0
fi

cd "$(dirname "${BASH_SOURCE[0]}")/.."
cargo build --release -p crumple
target=$(cargo metadata --format-version 1 --no-deps |
    sed 's/.*"target_directory":"\([^"]*\)".*/\1/')
mkdir -p out/bench
"$target/release/crumple" bench --json out/bench/bench.json "$@" | tee out/bench/RESULTS.md
if [[ $# -eq 0 ]]; then
    cargo bench -p crumple-master --bench kernels
    cargo bench -p crumple-master --bench kernels -- assembly | tee out/bench/assembly.md
fi
