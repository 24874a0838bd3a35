#!/usr/bin/env bash
# Prints docs/method.md's tables of measured errors, RMS (max) over pixels and R G B A at 256x256,
# everything else at its default.
#   tools/accuracy-table.sh [PSIVOX [FOLDER of .vdb files [NAME without .vdb ...]]]
set -euo pipefail
here=$(cd "$(dirname "$0")/.." && pwd)
psivox=${1:-$here/build/release/bin/psivox}
data=${2:-$here/../shared/data}
files=("${@:3}")
((${#files[@]})) || files=(smoke cloud_tiles heptane mri_t1)
rules=(cell-exact psi-weighted psi-balanced midpoint porter-duff) # the first: under cells only

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
export LC_ALL=C

render() { "$psivox" render "$input" -q --resolution 256x256 "$@"; }

# 1.3e-06 as 1.3e-6
number() { printf '%.1e' "$1" | sed 's/\(e[-+]\)0/\1/; s/e+0//'; }

# How far picture A is from B: RMS (max).
distance() {
  local rms max
  { read -r _ rms _; read -r _; read -r _ max _; } < <("$psivox" compare "$1" "$2")
  echo "$(number "$rms") ($(number "$max"))"
}

lookups() { printf '%.1f' "$(sed -n 's/.*"samples_per_ray": \([0-9.]*\).*/\1/p' "$1")"; }

header() {
  echo
  printf '| %s ' "$@"
  printf '|\n|'
  printf -- '---|%.0s' "$@"
  echo
}

# One sampling by every rule, against the reference.
row() {
  local name=$1 cells="" rule
  shift
  for rule in "${rules[@]}"; do
    if [[ $rule == cell-* && $name != cells ]]; then
      cells+=" – |"
      continue
    fi
    render "$@" --integrator "$rule" -o "$work/march.exr" --stats "$work/stats.json"
    cells+=" $(distance "$work/march.exr" "$work/reference.exr") |"
  done
  echo "| $name | $(lookups "$work/stats.json") |$cells"
}

arithmetic="" # rows of the last table
arithmetic_row() {
  local title=$1 cells="" options
  shift
  for options in "" "--step 1" "--texel float16"; do
    # shellcheck disable=SC2086  # options are words
    render "$@" $options --renderer march-double -o "$work/double.exr"
    # shellcheck disable=SC2086
    render "$@" $options -o "$work/march.exr"
    cells+=" $(distance "$work/march.exr" "$work/double.exr") |"
  done
  render "$@" --texel float16 -o "$work/half.exr"
  render "$@" -o "$work/march.exr"
  arithmetic+="| $title |$cells $(distance "$work/half.exr" "$work/march.exr") |"$'\n'
}

for file in "${files[@]}"; do
  input=$data/$file.vdb
  if [[ ! -f $input ]]; then
    echo "accuracy-table.sh: no $input: skipped" >&2
    continue
  fi
  scene=$(render --print-scene)
  grid=$(sed -n 's/^  "grid": "\(.*\)",$/\1/p' <<<"$scene")
  extinction=$(sed -n 's/^  "extinction": \(.*\),$/\1/p' <<<"$scene")
  for luminance in constant value; do
    options=()
    [[ $luminance == constant ]] || options=(--luminance-grid "$grid")
    title="$file, L $([[ $luminance == constant ]] && echo constant || echo "= value")"
    render "${options[@]}" --renderer reference -o "$work/reference.exr"
    printf '\n**%s**, extinction %.4g\n' "$title" "$extinction"
    header sampling "look-ups a ray" "${rules[@]}"
    row cells "${options[@]}"
    for step in 2 1 0.5 0.25; do row "step $step" "${options[@]}" --step "$step"; done
    arithmetic_row "$title" "${options[@]}"
  done
done

printf '\n**Arithmetic**: the GPU against the march in double\n'
header scene cells "step 1" "cells, float16" "GPU, float16 against float32"
printf '%s' "$arithmetic"
