#!/usr/bin/env bash
# Builds the kernels for a GPU and runs the prototype on it: `docs/developer/gpu.md`. With `build`
# it only builds. Needs a nightly toolchain with its sources
# (`rustup toolchain install nightly --component rust-src`), and for a run an NVIDIA driver.
# GPU_ARCH is the generation of the GPU (default sm_90: H100, H200).
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
arch=${GPU_ARCH:-sm_90}
out=$PWD/target/device
mkdir -p "$out"

# nvptx64 has no standard library, and the crates of elements and materials need one. That of zkVM,
# a system without files, compiles for it if it knows the alignment of memory of nvptx64: the line
# that sed adds.
sources=$(rustc +nightly --print sysroot)/lib/rustlib/src/rust
if [[ ! -d $sources/library ]]; then
    echo "device.sh: the sources of the nightly toolchain are missing:" \
        "rustup component add rust-src --toolchain nightly" >&2
    exit 2
fi
rm -rf "$out/rust"
mkdir -p "$out/rust"
cp -r "$sources/library" "$out/rust/library"
sed -i '0,/target_arch = "wasm32",/s//target_arch = "wasm32",\n    target_arch = "nvptx64",/' \
    "$out/rust/library/std/src/sys/alloc/mod.rs"
if ! grep -q nvptx64 "$out/rust/library/std/src/sys/alloc/mod.rs"; then
    echo "device.sh: the standard library of this toolchain has another list of alignments:" \
        "rustc 1.97 nightly is known to work" >&2
    exit 2
fi
rustc +nightly -Z unstable-options --print target-spec-json --target nvptx64-nvidia-cuda |
    python3 -c 'import json, sys
spec = json.load(sys.stdin)
spec["os"] = "zkvm"
json.dump(spec, sys.stdout, indent=1)' >"$out/nvptx64-std.json"

# Without these limits the compiler does not see that options are off, keeps the columns of an
# element in memory, and the kernel takes half as long again.
limits=(memdep-block-scan-limit=100000 memdep-block-number-limit=10000
    earlycse-mssa-optimization-cap=100000 gvn-max-num-deps=1000 unroll-threshold=800)
# PTX is text: there is nothing to link.
__CARGO_TESTS_ONLY_SRC_ROOT="$out/rust/library" RUSTFLAGS="-C target-cpu=$arch -C linker=true" \
    CARGO_TARGET_DIR="$out" \
    cargo +nightly rustc --profile device -Z build-std=std,panic_abort -Z json-target-spec \
    --target "$out/nvptx64-std.json" -p crumple-device-kernels --lib --crate-type cdylib -- \
    --emit=asm "${limits[@]/#/-Cllvm-args=-}"
cp "$out"/nvptx64-std/device/deps/crumple_device_kernels.s "$out/kernels.ptx"
cargo build --release -p crumple-device
[[ ${1:-} == build ]] && exit
target/release/crumple-device "$out/kernels.ptx"
