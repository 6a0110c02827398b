#!/usr/bin/env bash
# Installs what a build with MPI needs, and skips what is there: Open MPI, libclang, pkg-config, a C compiler.
#
#   deploy/setup.sh          installs only (Debian and Ubuntu; elsewhere it says what is missing)
#   source deploy/setup.sh   also sets the environment that mpirun needs on one machine; run.sh and test.sh do this

# Installs the named packages with apt, or says that it cannot.
crumple_install() {
    echo "setup: installing $*" >&2
    if ! command -v apt-get >/dev/null; then
        echo "setup: no apt-get here; install these by other means (on a cluster: module load): $*" >&2
        return 1
    fi
    local as_root=()
    if [[ $(id -u) -ne 0 ]]; then
        if ! command -v sudo >/dev/null; then
            echo "setup: neither root nor sudo; ask an administrator to: apt-get install $*" >&2
            return 1
        fi
        as_root=(sudo)
    fi
    local apt=("${as_root[@]}" env DEBIAN_FRONTEND=noninteractive NEEDRESTART_MODE=a
        apt-get -q -o DPkg::Lock::Timeout=300 -o Acquire::Retries=3)
    "${apt[@]}" update >&2 || echo "setup: apt-get update failed; going on with the package lists at hand" >&2
    "${apt[@]}" install -y --no-install-recommends "$@" >&2
}

# bindgen, which the MPI bindings use, needs the library and the compiler's own headers.
crumple_has_libclang() {
    [[ -n ${LIBCLANG_PATH:-} ]] && return 0
    if compgen -G '/usr/lib/llvm-*/lib/libclang[.-][0-9s]*' >/dev/null; then
        compgen -G '/usr/lib/llvm-*/lib/clang/*/include/stddef.h' >/dev/null
    else
        command -v clang >/dev/null && ldconfig -p 2>/dev/null | grep -q libclang
    fi
}

crumple_setup() {
    if ! command -v cargo >/dev/null && [[ -x $HOME/.cargo/bin/cargo ]]; then
        export PATH="$HOME/.cargo/bin:$PATH"
    fi
    if ! command -v cargo >/dev/null; then
        echo "setup: no cargo; install Rust first: https://rustup.rs" >&2
        return 1
    fi

    local missing=()
    command -v cc >/dev/null || missing+=(build-essential)
    command -v pkg-config >/dev/null || missing+=(pkg-config)
    command -v mpirun >/dev/null || missing+=(openmpi-bin)
    command -v mpicc >/dev/null || missing+=(libopenmpi-dev)
    crumple_has_libclang || missing+=(libclang-dev)
    if [[ ${#missing[@]} -gt 0 ]]; then
        crumple_install "${missing[@]}"
    else
        echo "setup: MPI, libclang and pkg-config are there" >&2
    fi
}

# One machine, more ranks than cores (the master mostly sleeps), perhaps root in a container.
crumple_mpi_environment() {
    export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
    export OMPI_MCA_rmaps_base_oversubscribe="${OMPI_MCA_rmaps_base_oversubscribe:-1}"
    # The same for Open MPI 5, which has another launcher.
    export PRTE_MCA_rmaps_default_mapping_policy="${PRTE_MCA_rmaps_default_mapping_policy:-:oversubscribe}"
    # Ranks are not tied to cores: jobs side by side would be tied to the same ones.
    export OMPI_MCA_hwloc_base_binding_policy="${OMPI_MCA_hwloc_base_binding_policy:-none}"
    # Copies from process to process through the kernel are forbidden in most containers; messages here are small.
    export OMPI_MCA_btl_vader_single_copy_mechanism="${OMPI_MCA_btl_vader_single_copy_mechanism:-none}"
}

if [[ ${BASH_SOURCE[0]} != "$0" ]]; then
    crumple_setup && crumple_mpi_environment
else
    set -euo pipefail
    crumple_setup
fi
