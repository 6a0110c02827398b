#!/usr/bin/env bash
# Installs the missing packages for a build with MPI: Open MPI, libclang, pkg-config, a C compiler.
#
#   deploy/setup.sh          only installs (Debian and Ubuntu; elsewhere it names missing packages)
#   source deploy/setup.sh   also sets the environment of mpirun for one machine, as in run.sh and
#                            test.sh

# Installs the named packages with apt, or reports that it cannot.
crumple_install() {
    echo "setup: installing $*" >&2
    if ! command -v apt-get >/dev/null; then
        echo "setup: no apt-get; install these in another way (on a cluster: module load): $*" >&2
        return 1
    fi
    local as_root=()
    if [[ $(id -u) -ne 0 ]]; then
        if ! command -v sudo >/dev/null; then
            echo "setup: neither root nor sudo; ask an administrator for: apt-get install $*" >&2
            return 1
        fi
        as_root=(sudo)
    fi
    local apt=("${as_root[@]}" env DEBIAN_FRONTEND=noninteractive NEEDRESTART_MODE=a
        apt-get -q -o DPkg::Lock::Timeout=300 -o Acquire::Retries=3)
    "${apt[@]}" update >&2 ||
        echo "setup: apt-get update failed; continuing with the present package lists" >&2
    "${apt[@]}" install -y --no-install-recommends "$@" >&2
}

# The MPI bindings use bindgen, which needs the library and the headers of the compiler.
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
        echo "setup: cargo is missing; install Rust first: https://rustup.rs" >&2
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
        echo "setup: MPI, libclang and pkg-config are present" >&2
    fi
}

# For one machine, more ranks than cores (the master mostly sleeps), and root in a container.
crumple_mpi_environment() {
    export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
    export OMPI_MCA_rmaps_base_oversubscribe="${OMPI_MCA_rmaps_base_oversubscribe:-1}"
    # The same for the launcher of Open MPI 5.
    local mapping="${PRTE_MCA_rmaps_default_mapping_policy:-:oversubscribe}"
    export PRTE_MCA_rmaps_default_mapping_policy="$mapping"
    # Ranks are not bound to cores: jobs that run at the same time would be bound to the same ones.
    export OMPI_MCA_hwloc_base_binding_policy="${OMPI_MCA_hwloc_base_binding_policy:-none}"
    # When mpirun itself is interrupted, ranks have so many seconds after TERM to write their state.
    # It waits for the same time before TERM.
    export OMPI_MCA_odls_base_sigkill_timeout="${OMPI_MCA_odls_base_sigkill_timeout:-5}"
    # Most containers forbid copies between processes through the kernel; messages here are small.
    local copies="${OMPI_MCA_btl_vader_single_copy_mechanism:-none}"
    export OMPI_MCA_btl_vader_single_copy_mechanism="$copies"
}

if [[ ${BASH_SOURCE[0]} != "$0" ]]; then
    crumple_setup && crumple_mpi_environment
else
    set -euo pipefail
    crumple_setup
fi
