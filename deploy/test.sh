#!/usr/bin/env bash
# Builds the workspace with MPI and runs all tests. Arguments are passed to cargo test. The output
# ends with the summaries of cargo.
#
# Variables for the programs that the tests start; this script sets the first two:
#   CRUMPLE_BIN       the crumple binary with MPI; tests start it directly and with mpirun
#   CRUMPLE_PYTHON    a Python with pyvista, with which tests read the field files through VTK. If
#                     unset, these tests are skipped
#   CRUMPLE_CHROMIUM  a Chromium that opens the report of a run. If unset, the first one in PATH;
#                     without one, the test is skipped
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

# shellcheck source=deploy/setup.sh
source deploy/setup.sh

# Prints the path of a Python with pyvista: that in PATH, or one in .venv, which is made if needed.
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
        echo "test: WARNING: no Python with pyvista; field files are not read through VTK" >&2
    fi
fi

cargo build --workspace --features crumple/mpi,crumple/vtkhdf
target=$(cargo metadata --format-version 1 --no-deps |
    sed 's/.*"target_directory":"\([^"]*\)".*/\1/')
export CRUMPLE_BIN=$target/debug/crumple

cargo test --workspace --features crumple/mpi,crumple/vtkhdf --no-fail-fast "$@"
# Every kernel of the benchmark once, to check that it still works. Times have no meaning here.
cargo test --quiet --benches -p crumple-master --features mpi,vtkhdf
# The scenes of the benchmark at a very small size, for the same reason.
"$CRUMPLE_BIN" bench --tiny --rounds 1
