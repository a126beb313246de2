#!/usr/bin/env bash
# A pipeline whose stages a batch system runs, on a private Slurm of two nodes on this machine: LAUNCH='srun -n1' makes the picture of a make
# without it, and a stage that fails in a job fails the make. Crops of one picture as an array of jobs, put together by oiiotool: the whole in
# every bit.
# Usage: slurm.sh BIN. Status 77: slurm-wlm or munge is not installed.
set -euo pipefail
bin=$(cd "$1" && pwd)
top=$(cd "$(dirname "$0")/../.." && pwd)
PATH=$PATH:/usr/sbin
for tool in munged slurmctld slurmd srun sbatch scancel; do
    command -v $tool > /dev/null || { echo "slurm.sh: $tool is not installed: apt-get install --no-install-recommends slurm-wlm munge" >&2; exit 77; }
done
folder=$(mktemp -d)
fail() { echo "slurm.sh: $*" >&2; exit 1; }
# Ends what this test started, by its id: jobs and their steps first.
end() {
    [ ! -s "$folder/slurmctld.pid" ] || scancel --user "$(id -un)" > "$folder/scancel.log" 2>&1 || true
    for daemon in n1 n2 slurmctld munged; do
        [ ! -s "$folder/$daemon.pid" ] || kill "$(< "$folder/$daemon.pid")" 2> /dev/null || true
    done
    for _ in $(seq 50); do
        left=
        for daemon in n1 n2 slurmctld munged; do
            [ ! -s "$folder/$daemon.pid" ] || ! kill -0 "$(< "$folder/$daemon.pid")" 2> /dev/null || left=yes
        done
        [ -n "$left" ] || break
        sleep 0.1
    done
    rm -rf "$folder"
}
trap end EXIT

# Ports that nothing uses. No cgroups, no accounting.
chmod 755 "$folder"
mkdir "$folder"/{state,n1,n2}
host=$(hostname -s)
port=
for p in $(seq $((20000 + $$ % 20000)) 47000); do
    (exec 3<> "/dev/tcp/127.0.0.1/$p") 2> /dev/null || { port=$p && break; }
done
cat > "$folder/slurm.conf" << EOF
ClusterName=private
SlurmctldHost=$host
SlurmUser=$(id -un)
SlurmdUser=$(id -un)
SlurmctldPort=$port
AuthType=auth/munge
AuthInfo=socket=$folder/munge.socket
StateSaveLocation=$folder/state
SlurmdSpoolDir=$folder/%n
SlurmctldPidFile=$folder/slurmctld.pid
SlurmdPidFile=$folder/%n.pid
SlurmctldLogFile=$folder/slurmctld.log
SlurmdLogFile=$folder/%n.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
SlurmdParameters=config_overrides
ReturnToService=2
MpiDefault=none
NodeName=n1 NodeHostname=$host Port=$((port + 1)) CPUs=2
NodeName=n2 NodeHostname=$host Port=$((port + 2)) CPUs=2
PartitionName=all Nodes=n1,n2 Default=YES State=UP
EOF
export SLURM_CONF=$folder/slurm.conf
dd if=/dev/urandom of="$folder/munge.key" bs=1024 count=1 2> /dev/null
chmod 600 "$folder/munge.key"
munged --force --key-file "$folder/munge.key" --socket "$folder/munge.socket" --pid-file "$folder/munged.pid" \
    --log-file "$folder/munged.log" --seed-file "$folder/munged.seed" 2> "$folder/munged.said" || fail "munged: $(cat "$folder/munged.said")"
slurmctld || fail "slurmctld: $(tail -n 3 "$folder/slurmctld.log")"
slurmd -N n1 || fail "slurmd: $(tail -n 3 "$folder/n1.log")"
slurmd -N n2 || fail "slurmd: $(tail -n 3 "$folder/n2.log")"
for _ in $(seq 100); do
    [ "$(sinfo -h -t idle -o %D 2> /dev/null)" != 2 ] || break
    sleep 0.2
done
[ "$(sinfo -h -t idle -o %D)" = 2 ] || fail "the nodes are not idle: $(sinfo -N -h; tail -n 3 "$folder/slurmctld.log")"

unset MAKELEVEL MAKEFLAGS MFLAGS
# picture OUT [LAUNCH=...]
picture() {
    local out=$1
    shift
    make -s --no-print-directory -C "$top/pipelines/cumulus" PICTURE=small BIN="$bin" OUT="$out" density_flags='--size 32' \
        render_flags='--resolution 48' "$@" > "$folder/said" 2>&1
}
picture "$folder/local" || fail "$(cat "$folder/said")"
picture "$folder/batch" LAUNCH='srun -Q -n1' || fail "LAUNCH: $(cat "$folder/said")"
idiff -q -fail 0 -warn 0 "$folder/local/cumulus.exr" "$folder/batch/cumulus.exr" || fail "LAUNCH makes another picture"
[ "$(squeue -h | wc -l)" = 0 ] || fail "jobs are left: $(squeue -h)"
# Each of the three stages was a job.
[ "$(srun -Q -n1 printenv SLURM_JOB_ID)" = 4 ] || fail "the stages were no jobs"
# A stage that fails in a job leaves no file of its own, and ends the make.
! picture "$folder/wrong" LAUNCH='srun -Q -n1' render_flags='--resolution 0' || fail "a stage failed in its job, and the make did not"
[ ! -e "$folder/wrong/cumulus.exr" ] && [ -e "$folder/wrong/cumulus.light.vdb" ] || fail "a stage that failed: $(ls "$folder/wrong")"

cd "$folder"
view=("$folder/local/cumulus.light.vdb" -q --resolution 48x36 --camera 0.2,0.7,4 --look-at 0,0.4,0 --samples 2 --background none)
"$bin/render" "${view[@]}" -o whole.exr
{
    echo '#!/bin/bash'
    echo 'y=$((SLURM_ARRAY_TASK_ID / 2 * 18)) x=$((SLURM_ARRAY_TASK_ID % 2 * 24))'
    printf '%q ' "$bin/render" "${view[@]}"
    echo '--crop $x,$y,$((x + 24)),$((y + 18)) -o crop.$SLURM_ARRAY_TASK_ID.exr'
} > job.sh
sbatch -Q --wait --array=0-3 -n1 -o 'job.%a.log' job.sh || fail "a crop failed: $(cat job.*.log)"
oiiotool crop.0.exr crop.1.exr --add crop.2.exr --add crop.3.exr --add -o sum.exr
idiff -q -fail 0 -warn 0 sum.exr whole.exr || fail "the crops together are another picture"
