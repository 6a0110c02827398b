#!/usr/bin/env bash
# Builds everything with MPI and runs all tests; arguments go to cargo test. Cargo's own summaries close the output.
#
# The tests find what they start by two variables, which this sets:
#   CRUMPLE_BIN     the crumple binary with MPI in it; tests start it directly and with mpirun
#   CRUMPLE_PYTHON  a Python with pyvista; tests read the field files through VTK with it. Unset: they skip that
#   CRUMPLE_CHROMIUM  a Chromium that opens the report of a run. Unset: the first in PATH, and without one that is skipped
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

# shellcheck source=deploy/setup.sh
source deploy/setup.sh

# Prints the path of a Python with pyvista: the one at hand, or one in .venv, made if need be.
python_with_vtk() {
    local python
    for python in "$(command -v python3)" "$PWD/.venv/bin/python"; do
        if [[ -x $python ]] && "$python" -c 'import dynars, lasso, pyvista' 2>/dev/null; then
            echo "$python"
            return 0
        fi
    done
    python3 -c 'import ensurepip, venv' 2>/dev/null || crumple_install python3-venv || return 1
    echo "test: installing pyvista into .venv" >&2
    python3 -m venv .venv >&2 || return 1
    timeout 600 .venv/bin/python -m pip install --quiet -r deploy/requirements.txt >&2 || return 1
    .venv/bin/python -c 'import dynars, lasso, pyvista' >&2 || return 1
    echo "$PWD/.venv/bin/python"
}

if [[ -z ${CRUMPLE_PYTHON:-} ]]; then
    if CRUMPLE_PYTHON=$(python_with_vtk); then
        export CRUMPLE_PYTHON
    else
        unset CRUMPLE_PYTHON
        echo "test: WARNING: no Python with pyvista; the field files are not read through VTK" >&2
    fi
fi

cargo build --workspace --features crumple/mpi,crumple/vtkhdf
target=$(cargo metadata --format-version 1 --no-deps | sed 's/.*"target_directory":"\([^"]*\)".*/\1/')
export CRUMPLE_BIN=$target/debug/crumple

cargo test --workspace --features crumple/mpi,crumple/vtkhdf --no-fail-fast "$@"
# Every kernel of the benchmark once, so that it does not rot; times mean nothing here.
cargo test --quiet --benches -p crumple --features mpi,vtkhdf
# The scenes of the benchmark at a tiny size, for the same reason.
"$CRUMPLE_BIN" bench --tiny --rounds 1
