#!/usr/bin/env bash
# Builds the manual in docs/ as HTML in book/. mdBook and KaTeX are compiled as libraries, see
# tests/book; formulas become MathML during the build.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

cargo run --quiet -p crumple-book
