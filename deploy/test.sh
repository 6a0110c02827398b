#!/usr/bin/env bash
# Builds the workspace with MPI and runs all tests. Arguments are passed to cargo test. The output
# ends with the summaries of cargo.
#
# It installs missing programs that tests need: MPI, a Python with pyvista in .venv, Chromium. If it
# may not install them (neither root nor sudo), it reports so, and their tests are skipped.
#
# Variables; this script sets CRUMPLE_BIN, and the others if they are not set:
#   CRUMPLE_BIN          the crumple binary; tests start it directly and with mpirun
#   CRUMPLE_PYTHON       a Python with the packages of deploy/requirements.txt, with which tests
#                        read field files through VTK
#   CRUMPLE_CHROMIUM     a Chromium that opens the report of a run; else the first one in PATH
#   CRUMPLE_REQUIRE_ALL  1: a test whose program is missing fails. 0: it is skipped with a notice.
#                        The default is 1 for root, who can install everything, and else 0
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

if [[ $(id -u) -eq 0 ]]; then
    export CRUMPLE_REQUIRE_ALL=${CRUMPLE_REQUIRE_ALL:-1}
fi

# Ends the script if all programs are required; otherwise reports that tests are skipped.
missing() {
    if [[ ${CRUMPLE_REQUIRE_ALL:-} == 1 ]]; then
        echo "test: ERROR: $*; CRUMPLE_REQUIRE_ALL=0 skips the tests that need it" >&2
        exit 1
    fi
    echo "test: WARNING: $*; tests that need it are skipped" >&2
}

# Packages of Python that tests import.
packages="dynars, lasso, mypy, pandas, pytest, pyvista, requests"

# Prints the path of a Python with pyvista: that in PATH, or one in .venv, which is made if needed.
python_with_vtk() {
    local python
    for python in "$(command -v python3)" "$PWD/.venv/bin/python"; do
        if [[ -x $python ]] && "$python" -c "import $packages" 2>/dev/null; then
            echo "$python"
            return 0
        fi
    done
    python3 -c 'import ensurepip, venv' 2>/dev/null || crumple_install python3-venv || return 1
    echo "test: installing pyvista into .venv" >&2
    python3 -m venv .venv >&2 || return 1
    timeout 600 .venv/bin/python -m pip install --quiet -r deploy/requirements.txt >&2 || return 1
    # VTK needs libraries of X, also where it draws nothing.
    if ! .venv/bin/python -c 'import pyvista' 2>/dev/null; then
        crumple_install libgl1 libxrender1 || return 1
    fi
    .venv/bin/python -c "import $packages" >&2 || return 1
    echo "$PWD/.venv/bin/python"
}

has_chromium() {
    [[ -n ${CRUMPLE_CHROMIUM:-} ]] || command -v chromium chromium-browser google-chrome \
        google-chrome-stable >/dev/null
}

features=crumple/vtkhdf
# shellcheck source=deploy/setup.sh
if source deploy/setup.sh; then
    features=crumple/mpi,$features
else
    command -v cargo >/dev/null || exit 1
    missing "no MPI"
fi

# The programs of the tests are installed while the workspace is built. Their paths and faults are
# in this folder.
found=$(mktemp -d)
finding=
trap '[[ -z $finding ]] || kill "$finding" 2>/dev/null || true; rm -rf "$found"' EXIT
{
    if [[ -z ${CRUMPLE_PYTHON:-} ]]; then
        python_with_vtk >"$found/python" || echo "no Python with pyvista" >>"$found/missing"
    fi
    has_chromium || crumple_install chromium || echo "no Chromium" >>"$found/missing"
} &
finding=$!
# Compiles the binary too, with the features of the tests: `cargo build` would compile the libraries
# a second time.
cargo test --workspace --features "$features" --no-run
wait "$finding"
finding=
if [[ -s $found/missing ]]; then
    while read -r what; do missing "$what"; done <"$found/missing"
fi
if [[ -s $found/python ]]; then
    CRUMPLE_PYTHON=$(<"$found/python")
    export CRUMPLE_PYTHON
elif [[ -z ${CRUMPLE_PYTHON:-} ]]; then
    unset CRUMPLE_PYTHON
fi
target=$(cargo metadata --format-version 1 --no-deps |
    sed 's/.*"target_directory":"\([^"]*\)".*/\1/')
export CRUMPLE_BIN=$target/debug/crumple

cargo test --workspace --features "$features" --no-fail-fast "$@"
# Every kernel of the benchmark once, to check that it still works. Times have no meaning here.
cargo test --quiet --workspace --features "$features" --bench kernels
# The scenes of the benchmark at a very small size, for the same reason.
"$CRUMPLE_BIN" bench --tiny --rounds 1
