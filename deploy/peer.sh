#!/usr/bin/env bash
# Times Crumple and another solver in turns on the same crush, and prints the ratio of each phase:
# `deploy/peer.py --help` has the settings. Run it on an idle machine.
#
#   CRUMPLE_PEER='my-radioss.sh {deck}' deploy/peer.sh             # the crushed tube, five rounds
#   CRUMPLE_PEER='my-radioss.sh {deck}' deploy/peer.sh cases/beam --end-time 1 --rounds 7
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
if [[ -z ${CRUMPLE_BIN:-} ]]; then
    cargo build --release -p crumple
    target=$(cargo metadata --format-version 1 --no-deps |
        sed 's/.*"target_directory":"\([^"]*\)".*/\1/')
    export CRUMPLE_BIN=$target/release/crumple
fi
exec python3 deploy/peer.py "$@"
