#!/usr/bin/env bash
# All checks, by hand and before a merge: format, lints, documentation, tests.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

# shellcheck source=deploy/setup.sh
source deploy/setup.sh

cargo fmt --all --check
cargo clippy --workspace --all-targets --all-features -- -D warnings
RUSTDOCFLAGS="-D warnings" cargo doc --workspace --no-deps --all-features
# Plain English and lines of 100 columns, where the texts are done.
git ls-files '*.md' 'cases/*.toml' 'deploy/*' 'tests/references/*' \
    ':!cases/REFERENCE.md' ':!cases/DECKS.md' ':!master/src/input/deck/reference_head.md' |
    xargs python3 deploy/words.py
if command -v mdbook mdbook-katex >/dev/null; then
    mdbook build docs
else
    echo "check: NOTICE: no mdbook with mdbook-katex; the manual in docs/ is not built" >&2
fi
deploy/test.sh "$@"
