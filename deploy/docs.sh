#!/usr/bin/env bash
# Builds the manual in docs/ as HTML in book/. Formulas become MathML during the build, by KaTeX.
# Install the programs once:
#
#     cargo install --locked mdbook@0.5.4 --no-default-features --features search
#     cargo install --locked mdbook-katex@0.10.0
#
# Without them the script prints a notice and ends with code 0.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

for program in mdbook mdbook-katex; do
    if ! command -v "$program" >/dev/null; then
        echo "docs: NOTICE: no $program; the manual in docs/ is not built" >&2
        exit 0
    fi
done
mdbook build docs
