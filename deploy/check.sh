#!/usr/bin/env bash
# All checks, by hand and before a merge: format, lints, documentation, tests.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

# shellcheck source=deploy/setup.sh
source deploy/setup.sh

cargo fmt --all --check
cargo clippy --workspace --all-targets --all-features -- -D warnings
RUSTDOCFLAGS="-D warnings" cargo doc --workspace --no-deps --all-features
# Plain English and lines of 100 columns, in all files that git knows.
python3 deploy/words.py
deploy/docs.sh
deploy/test.sh "$@"
