#!/usr/bin/env bash
# Runs the studies of docs/does-psi-pay.md into DIR and compares them: DIR/outside and DIR/inside
# receive the page's tables and plots. A second run keeps finished studies.
#   tools/does-psi-pay.sh DIR [PSIVOX [FOLDER of .vdb files]]
set -euo pipefail
here=$(cd "$(dirname "$0")/.." && pwd)
out=${1:?give a folder for the studies}
psivox=${2:-$here/build/release/bin/psivox}
data=${3:-$here/../shared/data}

# study NAME VIEW OPTIONS...: every rule under every sampling. Rays are parallel, so that templates
# can be drawn too; oblique, so that no lattice beats with the voxels'; and end at 1e-6 of the
# light.
study() {
  local name=$1 view=$2
  shift 2
  echo "$name, $view" >&2
  [ -s "$out/$view-$name/index.html" ] && return
  "$psivox" study "$data/${name%%-*}.vdb" -o "$out/$view-$name" --resume -q --no-split "$@" \
    --integrators all --samplings all --segments 1,4,16 \
    --steps 4,2,1,0.5,0.25,0.125,0.0625,0.03125 --tolerances 1e-2,1e-3,1e-4,1e-5 \
    --early-termination 1e-6 \
    --projection orthographic --resolution 128x128
}
both() { # NAME "CENTRE" WIDTH "INSIDE" WIDTH OPTIONS...: look along (-30, -17, -33)
  local name=$1 centre=$2 width=$3 inside=$4 inside_width=$5
  shift 5
  study "$name" outside "$@" --ortho-width "$width" --camera-target "$centre" \
    --camera-position "$(moved "$centre" 30)"
  study "$name" inside "$@" --ortho-width "$inside_width" --camera-position "$inside" \
    --camera-target "$(moved "$inside" -1)"
}
moved() { awk -F, -v n="$2" '{ printf "%.9g,%.9g,%.9g", $1 + 30 * n, $2 + 17 * n, $3 + 33 * n }' <<<"$1"; }

both smoke -7.4,40.5,0.5 90 -7.4,40.5,0.5 25 --luminance-grid density
both cloud_tiles -11.7,71.7,-45 480 60,95,30 120 --luminance-grid density --extinction 0.28
both heptane 163,150.5,150.5 330 163,150.5,150.5 120 --transfer-function "$here/assets/flame.json"
both mri_t1 61.5,80.5,68 190 61.5,80.5,68 60 --luminance-grid density

for view in outside inside; do
  rm -rf "${out:?}/$view"
  folders=$(printf "$out/$view-%s," smoke cloud_tiles heptane mri_t1)
  "$psivox" study --summary "${folders%,}" -o "$out/$view"
done
