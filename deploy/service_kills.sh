#!/usr/bin/env bash
# Kills a service at random moments while jobs arrive, wait, start, run and end, and sometimes also
# the supervisor, the master or a worker of a job (tests/tests/serve/torture.rs).
#
#   deploy/service_kills.sh [KILLS] [SEED]      default: 100 kills, seed 1
#
# At its end it reports what the kills met. It fails if a job is lost, ends twice or has other bits
# than an undisturbed run, or if a process or a temporary file is left.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
# shellcheck source=deploy/setup.sh
source deploy/setup.sh
export CRUMPLE_TORTURE_KILLS=${1:-100} CRUMPLE_TORTURE_SEED=${2:-1} CRUMPLE_TEST_LIMIT=900
export OMPI_MCA_odls_base_sigkill_timeout=1
options=(--workspace --features crumple/mpi,crumple/vtkhdf)
cargo test "${options[@]}" --no-run
exec cargo test "${options[@]}" --test serve torture -- --nocapture
