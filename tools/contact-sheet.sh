#!/usr/bin/env bash
# Draws every .vdb of some folders with one command, and a sheet of all pictures with their names:
#   tools/contact-sheet.sh SHEET.png FOLDER... [-- OPTIONS OF psivox render...]
# Takes the program from PSIVOX, else build/release/bin/psivox. Needs oiiotool (openimageio-tools).
set -euo pipefail
[ $# -ge 2 ] || { sed -n '2,4s/^# //p' "$0" >&2; exit 2; }
program=${PSIVOX:-$(dirname "$0")/../build/release/bin/psivox}
sheet=$1
shift
folders=()
while [ $# -gt 0 ] && [ "$1" != -- ]; do
  folders+=("$1")
  shift
done
[ $# -eq 0 ] || shift
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cells=()
for file in $(find "${folders[@]}" -maxdepth 1 -name '*.vdb' | sort); do
  name=$(basename "$file" .vdb)
  picture=$work/$name.png
  if ! "$program" render "$file" -o "$picture" --resolution 320x240 "$@" 2>"$work/said"; then
    tail -n 1 "$work/said" >&2
    continue
  fi
  echo "$((${#cells[@]} / 5 + 1)),$((${#cells[@]} % 5 + 1)) $name: $(grep -m 1 -o 'look [a-z]*' "$work/said" || echo 'look plain')"
  # names need a font
  oiiotool "$picture" --ch R,G,B --text:x=6:y=234:size=12 "$name" -o "$work/cell-$name.tif" 2>/dev/null ||
    oiiotool "$picture" --ch R,G,B -o "$work/cell-$name.tif"
  cells+=("$work/cell-$name.tif")
done
rows=$(((${#cells[@]} + 4) / 5))
oiiotool "${cells[@]}" --mosaic:pad=2 "5x$rows" -o "$sheet"
