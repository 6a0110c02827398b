#!/usr/bin/env bash
# Kills runs at random moments and lets them continue; compares digests and files with those of
# undisturbed runs (tests/tests/mpi/torture.rs).
#
#   deploy/torture.sh [ROUNDS] [SEED]      default: 300 rounds from seed 1
#
# At its end it reports rounds, kills, kills of the master and while checkpoints are written, the
# worst loss of work, orphan processes, temporary files and the time. A round that fails names its
# seed and leaves its folder.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
# shellcheck source=deploy/setup.sh
source deploy/setup.sh
export CRUMPLE_TORTURE_ROUNDS=${1:-300} CRUMPLE_TORTURE_SEED=${2:-1} CRUMPLE_TEST_LIMIT=900
export OMPI_MCA_odls_base_sigkill_timeout=1
cargo build --workspace --features crumple/mpi,crumple/vtkhdf
exec cargo test --workspace --features crumple/mpi,crumple/vtkhdf --test mpi torture -- --nocapture
