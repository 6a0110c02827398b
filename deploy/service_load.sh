#!/usr/bin/env bash
# Load of the service: watchers of a run, submissions, a long list, a week of events. Writes
# cases/bench/service_load.csv (deploy/service_load.py). It takes some minutes.
#
#   deploy/service_load.sh [OPTIONS]      options of deploy/service_load.py, such as --watchers 100
#
# CRUMPLE_BIN names the program; without it, it is built.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
if [[ -z ${CRUMPLE_BIN:-} ]]; then
    cargo build --release -p crumple
    target=$(cargo metadata --format-version 1 --no-deps |
        sed 's/.*"target_directory":"\([^"]*\)".*/\1/')
    CRUMPLE_BIN=$target/release/crumple
fi
ulimit -n 8192
exec python3 deploy/service_load.py "$CRUMPLE_BIN" "$@"
