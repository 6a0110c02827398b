#!/usr/bin/env bash
# Builds Crumple with MPI and runs a job with a master and its workers on this machine.
#
#   deploy/run.sh                                     the jeep frame; results in out/jeep-frame
#   deploy/run.sh cases/tumble --end-time 1           another job, and options of `crumple run`
#   WORKERS=4 deploy/run.sh                           four workers; the default is one per core
#   WORKERS=2 deploy/run.sh JOB --threads 4           two workers, each with four threads; threads
#                                                     that only the job names are not known here
#   RETRIES=3 deploy/run.sh                           starts again when a worker is lost
#   CRUMPLE=target/debug/crumple deploy/run.sh        a binary with MPI that is there already
#   deploy/run.sh serve                               a service for jobs; prints its address
set -euo pipefail
if [[ ${1:-} == -h || ${1:-} == --help ]]; then
    sed -n '2,11s/^# \{0,1\}//p' "$0"
    exit 0
fi

caller=$PWD
cd "$(dirname "${BASH_SOURCE[0]}")/.."
root=$PWD

serve=
if [[ ${1:-} == serve ]]; then
    serve=1
    shift
fi

# The path of a job is relative to the folder of the caller, or else to the root of the repository.
job=$root/cases/jeep-frame
if [[ -z $serve && $# -gt 0 && $1 != -* ]]; then
    job=$1
    shift
    [[ $job != /* && -e $caller/$job ]] && job=$caller/$job
fi
name=$(basename "$job")
[[ $name == job.toml ]] && name=$(basename "$(dirname "$job")")
name=${name%.*}

out=
threads=1
arguments=("$@")
for ((i = 0; i < $#; i++)); do
    case ${arguments[i]} in
        --out) out=${arguments[i + 1]:-} ;;
        --out=*) out=${arguments[i]#--out=} ;;
        --threads) threads=${arguments[i + 1]:-} ;;
        --threads=*) threads=${arguments[i]#--threads=} ;;
        *parallel.threads=*) threads=${arguments[i]#*parallel.threads=} ;;
    esac
done
if [[ -z $serve && -z $out ]]; then
    out=out/$name
    arguments+=(--out "$out")
fi

# The threads of a worker need more than one core.
bind=
if [[ $threads =~ ^[1-9][0-9]*$ && $threads -gt 1 ]]; then
    bind=" --bind-to none"
else
    threads=1 # the program reports what is no number
fi
cores=$(nproc)
workers=${WORKERS:-$((cores > threads ? cores / threads : 1))}
if ! [[ $workers =~ ^[1-9][0-9]*$ ]]; then
    echo "run: WORKERS is '$workers'; it must be a number of at least 1" >&2
    exit 2
fi

# shellcheck source=deploy/setup.sh
source deploy/setup.sh

program=${CRUMPLE:-}
if [[ -z $program ]]; then
    cargo build --release --features mpi -p crumple
    target=$(cargo metadata --format-version 1 --no-deps |
        sed 's/.*"target_directory":"\([^"]*\)".*/\1/')
    program=$target/release/crumple
fi

[[ -z $serve ]] || exec "$program" serve "${arguments[@]}"
echo "run: a master and $workers workers on $job"
# A supervisor starts the ranks. It lets them stop in order when this script is interrupted, and
# starts them again from the newest checkpoint when one is lost, as often as RETRIES allows.
run= early= interrupted=
pass_on() {
    [[ $1 == USR1 ]] || interrupted=1
    if [[ -z $run ]]; then
        early=$1
    else
        kill "-$1" "$run" 2>/dev/null || true
    fi
}
trap 'pass_on TERM' INT TERM HUP
trap 'pass_on USR1' USR1
"$program" run "$job" "${arguments[@]}" --retries "${RETRIES:-0}" --workers "$workers" \
    --launcher "mpirun$bind -n {ranks}" &
run=$!
[[ -z $early ]] || pass_on "$early"
# A signal ends `wait` early, with a code above 128.
code=0
while wait "$run" && code=0 || code=$?; kill -0 "$run" 2>/dev/null; do :; done
wait "$run" && code=0 || code=$? # the loop may have left the code of a signal
# A program that has not begun to listen for signals ends by the signal itself.
[[ -n $interrupted && $code -eq 143 ]] && code=130

if [[ -f $out/summary.json ]]; then
    cat <<END

Results in $(cd "$out" && pwd):
  summary.json      results in numbers
  history.csv       energies, contact and wall force over time
  fields/fields.pvd open it in ParaView; or: python3 deploy/read_fields.py $out
END
fi
[[ $code -eq 0 ]] || echo "run: crumple ended with code $code (2 bad input or unwritten files," \
    "3 numerical failure, 4 a worker lost, 130 stopped)" >&2
if [[ -f $out/report.html ]]; then
    echo "Animation, plots and tables on one page: $(cd "$out" && pwd)/report.html"
fi
exit "$code"
