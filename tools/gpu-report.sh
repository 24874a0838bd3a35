#!/usr/bin/env bash
# gpu-report.sh SCENE.json|FILE.vdb ...: prints the model's predictions for pictures of 1920x1080 at
# a tolerance of 1e-3 (docs/gpu.md), and below them what this machine's GPU takes: the least of five
# marches. Run it in the source folder after a build of psivox_program and psivox_gpu_cost.
set -euo pipefail

build=${PSIVOX_BUILD:-build/release}
fail() {
  printf 'gpu-report.sh: %s\n' "$1" >&2
  exit "$2"
}
(($# > 0)) || fail 'name scenes or volumes, for example tools/bench/scenes/smoke-thin.json' 2
for program in bin/psivox tools/gpu_cost; do
  [[ -x $build/$program ]] || fail "$build/$program is missing; PSIVOX_BUILD names another folder" 2
done
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# The picture's, which comes last: a plan's trials have numbers of the same names.
number() { grep -oE "\"$1\": [0-9.e+-]+" "$work/stats.json" | tail -n 1 | cut -d' ' -f2; }

for scene in "$@"; do
  "$build/tools/gpu_cost" "$scene"
  input=("$scene" --look plain)
  [[ $scene == *.json ]] && input=(--scene "$scene")
  for _ in 1 2 3 4 5; do
    "$build/bin/psivox" render "${input[@]}" --resolution 1920x1080 --tolerance 1e-3 -q \
      -o "$work/picture.exr" --stats "$work/stats.json"
    number march
  done | sort -g | head -n 1 >"$work/least"
  printf '| measured: %s | | | %.2f | %s look-ups a ray |\n' \
    "$(grep -oE '"renderer": "[^"]*"' "$work/stats.json" | cut -d'"' -f4)" \
    "$(cat "$work/least")" "$(number samples_per_ray | cut -c1-5)"
done
