#!/usr/bin/env bash
# slurm_test.sh PSIVOX ASSETS SCRIPT: renders a sequence on a Slurm of its own, of one node, kills a
# task and submits again. All frames must then be those of one process. Without Slurm or an EGL
# device it is skipped (exit 77).
set -u
program=$1 assets=$2 script=$3
PATH=$PATH:/usr/sbin
for command in munged slurmctld slurmd sbatch scancel; do
  command -v "$command" >/dev/null && continue
  echo "skipped: no $command (Debian: slurm-wlm)"
  exit 77
done
if ! "$program" render --list-devices | grep -q "4\.[5-9]"; then
  echo "skipped: no EGL device"
  exit 77
fi

work=$(mktemp -d)
daemons=()
finish() {
  kill "${daemons[@]}" 2>/dev/null
  wait "${daemons[@]}" 2>/dev/null
  rm -rf "$work"
}
trap finish EXIT
cd "$work" || exit 1
fail() {
  echo "FAILED: $1"
  tail -n 5 "$work"/*.out "$work"/*.log 2>/dev/null
  exit 1
}
# wait_for WHAT COMMAND...: until the command succeeds, a minute at most.
wait_for() {
  local what=$1 tries
  shift
  for ((tries = 0; tries < 600; tries++)); do
    "$@" >/dev/null 2>&1 && return
    sleep 0.1
  done
  fail "no $what after a minute"
}

# Slurm refuses a key that others can read. Ports and names are this test's own.
chmod 700 "$work"
head -c 1024 /dev/urandom >key && chmod 600 key
port=$((20000 + $$ % 20000))
node=$(hostname -s) user=$(id -un)
mkdir state spool
cat >slurm.conf <<END
ClusterName=psivox
SlurmctldHost=$node(127.0.0.1)
NodeName=$node NodeAddr=127.0.0.1 CPUs=2 State=UNKNOWN
PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP
SlurmUser=$user
SlurmdUser=$user
AuthType=auth/munge
AuthInfo=socket=$work/munge.socket
SlurmctldPort=$port
SlurmdPort=$((port + 1))
StateSaveLocation=$work/state
SlurmdSpoolDir=$work/spool
SlurmctldPidFile=$work/slurmctld.pid
SlurmdPidFile=$work/slurmd.pid
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
SchedulerParameters=batch_sched_delay=0,sched_interval=1
KillWait=2
ReturnToService=2
MpiDefault=none
END
export SLURM_CONF=$work/slurm.conf
munged --foreground --force --key-file=key --socket="$work/munge.socket" --seed-file=seed \
  --pid-file="$work/munged.pid" --log-file="$work/munged.log" >munged.out 2>&1 &
daemons+=($!)
slurmctld -D -i >slurmctld.out 2>&1 &
daemons+=($!)
slurmd -D >slurmd.out 2>&1 &
daemons+=($!)
idle() { sinfo --noheader --format=%t | grep -qx idle; }
wait_for "idle node" idle

# Frames of different volumes. The second task, 4 to 6, can be killed after its first frame, the
# quickest, because its second takes longest.
volumes=(blobs ramp slab rotated single_voxel tiles)
frames=9
for ((i = 1; i <= frames; i++)); do
  ln -s "$assets/${volumes[i % ${#volumes[@]}]}.vdb" "$(printf 'in.%04d.vdb' "$i")"
done
options=(--grid density --resolution 256x256 --pixel-samples 16 -q)
picture() { printf '%s.%04d.exr' "$1" "$2"; }

"$program" render 'in.####.vdb' -o 'alone.####.exr' --frames 1-$frames "${options[@]}" ||
  fail "one process ends with $?"

export PSIVOX=$program
submit=(sbatch --parsable --array=0-2 --output=task.%A.%a.log "$script" "1-$frames"
  'in.####.vdb' -o 'farm.####.exr' "${options[@]}")
job=$("${submit[@]}") || fail "sbatch ends with $?"
# The second task draws frames 4 to 6: it is killed when the first of them stands.
wait_for "frame 4" test -e "$(picture farm 4)"
scancel --signal=KILL --full "${job}_1"
ended() { [ -z "$(squeue --noheader --jobs="$job" 2>/dev/null)" ]; }
wait_for "end of the job" ended
[ ! -e "$(picture farm 6)" ] || fail "the task ended before it was killed"
before=$(stat -c '%n %i %y' farm.*)

"${submit[@]:0:1}" --wait "${submit[@]:1}" >/dev/null || fail "the array ends with $?"
for ((i = 1; i <= frames; i++)); do
  "$program" compare "$(picture alone "$i")" "$(picture farm "$i")" --max-abs 0 >/dev/null ||
    fail "frame $i is not that of one process"
done
again=$(comm -23 <(sort <<<"$before") <(stat -c '%n %i %y' farm.* | sort))
[ -z "$again" ] || fail "frames that stood were drawn again: $again"
stray=$(find . -name 'farm.*' -o -name '.farm*' | grep -cv '/farm\.[0-9]*\.exr$')
[ "$stray" -eq 0 ] || fail "$stray stray files"
echo "$frames frames by an array of 3 tasks, one of them killed: those of one process"

# One frame over 4 ranks, by Open MPI through PMIx, which Slurm starts.
libraries=$(dirname "$(ldd "$program" | sed -n 's/.*libpsivox\.so[^ ]* => \([^ ]*\) .*/\1/p')")
if [ -e "$libraries/psivox/libpsivox_openmpi.so" ] && srun --mpi=list 2>&1 | grep -qw pmix; then
  scene=(--look plain --sampling cells --early-termination 0 --resolution 64x48)
  "$program" render "$assets/blobs.vdb" -o one.exr "${scene[@]}" -q || fail "one process"
  OMPI_MCA_btl_vader_single_copy_mechanism=none timeout 120 srun --mpi=pmix --overcommit -n 4 \
    "$program" render "$assets/blobs.vdb" -o ranks.exr "${scene[@]}" >srun.log 2>&1 ||
    fail "srun of 4 ranks ends with $?"
  # rounded to float32 in each rank and in the fold, 1e-7 of values about 1
  "$program" compare one.exr ranks.exr --max-rms 1e-6 >/dev/null || fail "4 ranks draw another picture"
  # the first rank speaks for all; processes that know nothing of each other would say it four times
  [ "$(grep -c 'chosen by auto' srun.log)" -eq 1 ] || fail "srun: not one job of 4 ranks"
  echo "one frame over 4 ranks: that of one process"
else
  echo "one frame over ranks: left out, no Open MPI or no PMIx in Slurm"
fi
