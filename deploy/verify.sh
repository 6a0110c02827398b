#!/usr/bin/env bash
# Runs all checks of the catalogue, also the slow ones, and compares their rows with the committed
# table tests/verification.json; then the long jobs under cases/, whose warnings are checked. Takes
# an hour. `CRUMPLE_SLOW=1 .ci/run` runs it after the tests.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

cargo test --release --workspace --test verification -- --include-ignored "$@"
CRUMPLE_TEST_LIMIT=3600 cargo test --release --workspace --test results -- --ignored long_jobs
