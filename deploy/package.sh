#!/usr/bin/env bash
# Builds the files of a release into dist/: a static binary for x86-64 with AVX2 and without MPI,
# the Python wheel, manual pages, completions, and the checksums of all.
#
#   deploy/package.sh                 # optimised, as they are given away
#   deploy/package.sh --profile dev   # to try the script
#
# It needs cargo, binutils, a C library for static programs (Debian: libc6-dev), python3 with pip
# and venv, and a registry of Python packages for maturin and zig.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

profile=release
if [[ ${1:-} == --profile && -n ${2:-} ]]; then
    profile=$2
elif [[ $# -gt 0 ]]; then
    echo "package: ERROR: unknown argument $1; use --profile NAME or none" >&2
    exit 2
fi

target=x86_64-unknown-linux-gnu
# The program has to run on other machines than this one.
cpu="-C target-cpu=x86-64-v3"
dist=$PWD/dist
rm -rf "$dist"
mkdir -p "$dist"

RUSTFLAGS="$cpu -C target-feature=+crt-static" \
    cargo build --locked --profile "$profile" --target "$target" -p crumple --features vtkhdf
folder=$(cargo metadata --format-version 1 --no-deps |
    sed 's/.*"target_directory":"\([^"]*\)".*/\1/')/$target
[[ $profile == dev ]] && folder=$folder/debug || folder=$folder/$profile
version=$("$folder/crumple" --version | cut -d ' ' -f 2)
binary=crumple-$version-$target
# Without the tables for debuggers, which are most of the file; messages of panics stay complete.
strip --strip-debug -o "$dist/$binary" "$folder/crumple"
headers=$(readelf --program-headers --wide "$dist/$binary")
if grep -q INTERP <<<"$headers"; then
    echo "package: ERROR: $dist/$binary needs shared libraries" >&2
    exit 1
fi

"$dist/$binary" manual "$dist/man"
mkdir "$dist/completions"
for shell in bash zsh fish; do
    "$dist/$binary" completions "$shell" >"$dist/completions/crumple.$shell"
done

# Its own environment, so that the build needs nothing of this machine's Python. Zig links against
# an older C library than that of this machine, so that the wheel is good for all systems with the
# one that its name states; maturin checks this.
python=$(mktemp -d)
trap 'rm -rf "$python"' EXIT
python3 -m venv "$python"
"$python/bin/python" -m pip install --quiet 'maturin>=1.7,<2' ziglang
RUSTFLAGS=$cpu PATH=$python/bin:$PATH "$python/bin/maturin" build --quiet --zig --locked \
    --target "$target" --compatibility manylinux_2_28 --profile "$profile" --out "$dist"
wheels=("$dist"/crumple-*-manylinux_2_28_x86_64.whl)
if [[ ! -f ${wheels[0]} ]]; then
    echo "package: ERROR: the wheel has no tag of manylinux" >&2
    exit 1
fi
"$python/bin/python" -m pip install --quiet "${wheels[0]}"
"$python/bin/python" -c '
import crumple
from importlib.metadata import version
print("package: the wheel has version", version(crumple.__name__))
'

(cd "$dist" && find . -type f ! -name SHA256SUMS | sort | xargs sha256sum >SHA256SUMS)
echo "package: $(find "$dist" -type f | wc -l) files in $dist"
