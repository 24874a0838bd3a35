#!/usr/bin/env bash
# Renders a sequence as an array of Slurm jobs; each task draws its share of the frames:
#   sbatch --array=0-9 tools/slurm-frames.sh 1-100 'fire.####.vdb' -o 'fire.####.png' ...
# The frames are A-B or A-BxSTEP; what follows are arguments of `psivox render`. Every task chooses
# `auto` from the whole sequence, so all frames match. The same command again draws what is missing.
# Takes the program from PSIVOX, else from PATH.
#SBATCH --job-name=psivox
#SBATCH --requeue
set -euo pipefail

fail() {
  printf 'slurm-frames.sh: %s\n' "$1" >&2
  exit 2
}

[ $# -ge 2 ] || { sed -n '2,6s/^# //p' "$0" >&2; exit 2; }
[[ $1 =~ ^([0-9]+)-([0-9]+)(x([0-9]+))?$ ]] ||
  fail "expected frames such as 1-100 or 1-100x2 instead of '$1'"
first=$((10#${BASH_REMATCH[1]})) last=$((10#${BASH_REMATCH[2]})) step=$((10#${BASH_REMATCH[4]:-1}))
shift
((step > 0 && last >= first)) || fail "no frame from $first to $last by $step"
[ -n "${SLURM_ARRAY_TASK_ID:-}" ] || fail "not a task of an array; submit it with sbatch --array=0-9"

# The shares of all tasks are all frames.
tasks=$((SLURM_ARRAY_TASK_MAX - SLURM_ARRAY_TASK_MIN + 1))
place=$((SLURM_ARRAY_TASK_ID - SLURM_ARRAY_TASK_MIN))
((SLURM_ARRAY_TASK_COUNT == tasks)) || fail "number the tasks without gaps, such as --array=0-9"
frames=$(((last - first) / step + 1))
from=$((frames * place / tasks)) to=$((frames * (place + 1) / tasks))
((from < to)) || { echo "more tasks than frames: nothing to do"; exit 0; }
share=$((first + step * from))-$((first + step * (to - 1)))x$step

echo "frames $share"
# exec: Slurm's signals reach psivox, which then finishes or removes its files
exec "${PSIVOX:-psivox}" render --frames "$share" --resume --keep-going "$@"
