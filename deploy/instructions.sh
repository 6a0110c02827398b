#!/usr/bin/env bash
# Counts the instructions of single kernels with valgrind. Counts do not depend on the load.
#
#   deploy/instructions.sh                   all kernels, compared with cases/bench/instructions.txt
#   deploy/instructions.sh hexahedron ...    some of them
#   deploy/instructions.sh --write           writes that file
#
# Built for x86-64-v2, because valgrind lacks AVX-512 and some AVX2 instructions: lanes have two
# numbers and not four. Use the counts only to compare versions of the code. If a count is more than
# a tenth above that in the file, the script prints MORE and exits with 1.
set -euo pipefail

if [[ ${1:-} == -h || ${1:-} == --help ]]; then
    sed -n '2,10s/^# \{0,1\}//p' "$0"
    exit 0
fi
command -v valgrind >/dev/null || {
    echo "error: valgrind is missing; install the package valgrind" >&2
    exit 2
}

cd "$(dirname "${BASH_SOURCE[0]}")/.."
file=cases/bench/instructions.txt
target=$(cargo metadata --format-version 1 --no-deps |
    sed 's/.*"target_directory":"\([^"]*\)".*/\1/')/counted
# Without libc, rustix reads the auxiliary vector at the start, which fails under valgrind.
export RUSTFLAGS="-C target-cpu=x86-64-v2 --cfg rustix_use_libc" CARGO_TARGET_DIR=$target
cargo build --release -p crumple-master --bench kernels
kernels=$(find "$target/release/deps" -name 'kernels-*' -executable -type f -printf '%T@ %p\n' |
    sort -n | tail -n 1 | cut -d ' ' -f 2-)

write=false
if [[ ${1:-} == --write ]]; then
    write=true
    shift
fi
$write || [[ -f $file ]] || echo "note: $file is missing, no comparison; --write makes it" >&2
wanted=" $* "
lines=""
worse=0
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
while read -r name count what; do
    [[ $# -eq 0 || $wanted == *" $name "* ]] || continue
    valgrind --tool=callgrind --callgrind-out-file="$scratch/out" \
        --toggle-collect='*instructions::counted*' \
        "$kernels" count "$name" 1 >/dev/null 2>"$scratch/err" || {
        cat "$scratch/err" >&2
        exit 2
    }
    each=$(awk -v n="$count" '/^(summary|totals):/ { sum = $2 } END { printf "%.1f", sum / n }' \
        "$scratch/out")
    before=$(awk -v name="$name" '$1 == name { print $2 }' "$file" 2>/dev/null || true)
    note=""
    if [[ -n $before ]]; then
        note=$(awk -v a="$each" -v b="$before" 'BEGIN { printf "%.3f of %s", a / b, b }')
        if awk -v a="$each" -v b="$before" 'BEGIN { exit !(a > 1.1 * b) }'; then
            note+="  MORE"
            worse=1
        fi
    fi
    echo "$name: $each instructions for each of $count $what  $note"
    lines+="$name $each"$'\n'
done < <("$kernels" count)
if $write; then
    printf '%s' "$lines" >"$file"
    echo "written: $file"
    exit 0
fi
exit "$worse"
