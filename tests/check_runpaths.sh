#!/usr/bin/env bash
# Checks where what was built looks for libraries: beside itself, or in a folder outside of the
# build. An empty or relative entry is the folder in which somebody works, whose files would run.
# check_runpaths.sh BUILD
set -euo pipefail
command -v readelf >/dev/null || { echo "no readelf: skipped"; exit 77; }
build=$(realpath "$1")
read_files=0 bad=0
while IFS= read -r -d '' file; do
  [ "$(head -c 4 "$file")" = $'\x7fELF' ] || continue
  read_files=$((read_files + 1))
  paths=$(readelf -dW "$file" | sed -nE 's/.*\((RUNPATH|RPATH)\).*\[(.*)\]$/\2:/p')
  while [ -n "$paths" ]; do
    entry=${paths%%:*} paths=${paths#*:}
    [[ $entry == "\$ORIGIN" || $entry == "\$ORIGIN/"* || ($entry == /* && $entry/ != "$build"/*) ]] ||
      { echo "$file: its RUNPATH has '$entry'" >&2; bad=1; }
  done
done < <(find "$build" -name CMakeFiles -prune -o -name files -prune -o -type f \
  \( -perm -u+x -o -name '*.so*' \) -print0)
((read_files >= 3)) || { echo "$read_files programs and libraries found, expected 3" >&2; bad=1; }
[ $bad = 0 ] && echo "the RUNPATHs of $read_files programs and libraries are safe"
exit $bad
