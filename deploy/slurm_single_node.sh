#!/usr/bin/env bash
# Runs a command with a Slurm of its own: munge, slurmctld and slurmd on this machine, in a
# temporary folder, as root. They end with the command.
#
#   deploy/slurm_single_node.sh sinfo
#   deploy/slurm_single_node.sh deploy/test.sh --test serve real_slurm -- --ignored
#
# It needs Debian's packages munge, slurmctld, slurmd and slurm-client. It uses neither cgroups nor
# accounting, so that it works in a container. One job has the whole node; others wait.
set -euo pipefail

for program in munged mungekey slurmctld slurmd sbatch; do
    command -v "$program" >/dev/null || PATH=$PATH:/usr/sbin command -v "$program" >/dev/null || {
        echo "slurm: $program is missing: apt-get install munge slurmctld slurmd slurm-client" >&2
        exit 1
    }
done
PATH=$PATH:/usr/sbin
[[ $# -gt 0 ]] || { echo "usage: $0 COMMAND..." >&2 && exit 2; }
[[ $(id -u) -eq 0 ]] || { echo "slurm: slurmd starts jobs as root only" >&2 && exit 1; }

dir=$(mktemp -d -t slurm.XXXXXX)
daemons=()
finish() {
    # In the opposite order; slurmd ends its jobs first.
    for ((i = ${#daemons[@]} - 1; i >= 0; i--)); do
        kill "${daemons[i]}" 2>/dev/null && wait "${daemons[i]}" 2>/dev/null || true
    done
    rm -rf "$dir"
}
trap finish EXIT
chmod 755 "$dir"
mkdir -m 700 "$dir/munge" "$dir/state" "$dir/spool"

# Prints free ports.
free_ports() {
    python3 -c 'import socket
all = [socket.socket() for _ in range(2)]
for one in all: one.bind(("127.0.0.1", 0))
print(*(one.getsockname()[1] for one in all))'
}
read -r port node_port < <(free_ports)

node=$(hostname -s)
cat >"$dir/slurm.conf" <<END
ClusterName=single
SlurmctldHost=$node(127.0.0.1)
SlurmctldPort=$port
SlurmdPort=$node_port
SlurmUser=root
AuthType=auth/munge
AuthInfo=socket=$dir/munge/socket
CredType=cred/munge
StateSaveLocation=$dir/state
SlurmdSpoolDir=$dir/spool
SlurmctldPidFile=$dir/slurmctld.pid
SlurmdPidFile=$dir/slurmd.pid
SlurmctldLogFile=$dir/slurmctld.log
SlurmdLogFile=$dir/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/linear
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
SchedulerType=sched/builtin
MpiDefault=none
ReturnToService=2
MinJobAge=10
KillWait=30
NodeName=$node NodeAddr=127.0.0.1 CPUs=$(nproc) State=UNKNOWN
PartitionName=all Nodes=$node Default=YES MaxTime=INFINITE State=UP
END
export SLURM_CONF=$dir/slurm.conf

mungekey --create --keyfile "$dir/munge/key"
munged --foreground --force --key-file "$dir/munge/key" --socket "$dir/munge/socket" \
    --pid-file "$dir/munge/pid" --seed-file "$dir/munge/seed" 2>"$dir/munge/log" &
daemons+=($!)
slurmctld -D -f "$SLURM_CONF" 2>"$dir/slurmctld.err" &
daemons+=($!)
slurmd -D -N "$node" -f "$SLURM_CONF" 2>"$dir/slurmd.err" &
daemons+=($!)
for _ in {1..100}; do
    [[ $(sinfo --noheader --format=%T 2>/dev/null) == idle ]] && break
    sleep 0.3
done
if [[ $(sinfo --noheader --format=%T 2>&1) != idle ]]; then
    echo "slurm: the node is not ready: $(sinfo 2>&1)" >&2
    tail -n 20 "$dir"/munge/log "$dir"/slurm*.log "$dir"/slurm*.err >&2 || true
    exit 1
fi
"$@"
