#!/usr/bin/env bash
# Checks includes against the directions of dependency in docs/architecture.md. check_includes.sh
# [ROOT]
set -euo pipefail
cd "${1:-$(dirname "$0")/..}"
bad=0
complain() {
  echo "$1: $2" >&2
  bad=1
}

# All includes of C++ files as "file:line:path", angle brackets and quotes alike.
includes() {
  { grep -rnE --include='*.cpp' --include='*.h' --include='*.h.in' '^[[:space:]]*#[[:space:]]*include' "$@" || true; } |
    sed -E 's/^([^:]+:[0-9]+):[[:space:]]*#[[:space:]]*include[[:space:]]*[<"]([^>"]+)[>"].*/\1 \2/'
}
folders=(include src)
for folder in tools tests; do
  [ -d "$folder" ] && folders+=("$folder")
done

# --- packages: each is known to one component -----------------------------------------------------
# only_in PATTERN WHERE...: only files that match one of WHERE may include headers that match
# PATTERN.
only_in() {
  local pattern=$1 place header
  shift
  while read -r place header; do
    [[ $header =~ $pattern ]] || continue
    local allowed=0 where
    for where in "$@"; do
      [[ ${place%%:*} =~ $where ]] && allowed=1
    done
    [ $allowed = 1 ] || complain "$place" "<$header> belongs in $*"
  done < <(includes "${folders[@]}")
}
only_in '^openvdb/' '^src/reader/' '^tools/make_assets\.cpp$' '^tools/bench/nanovdb_' '^tests/vdb_' '^tests/fuzz/make_volumes\.cpp$'
only_in '^nanovdb/' '^src/reader/nano_' '^tools/bench/nanovdb_'
only_in '^(OpenEXR/|png\.h)' '^src/image/'
only_in '^OpenImageIO/' '^src/oiio/' '^tests/(image_cases\.h|(deep|ocio)_test\.cpp)$'
only_in '^(epoxy|EGL|GL|GLES[23]|KHR)/' '^src/gl/' '^src/view/(window|picture_display)\.' '^tests/gl_trouble_test\.cpp$'
only_in '^nlohmann/' '^src/app/' '^src/look/' '^src/medium/' '^src/page/' '^src/scene/' '^src/sequence/' '^src/study/' '^tools/'
only_in '^pugixml' '^src/scene/'
only_in '^CLI/' '^tools/'
only_in '^zlib\.h' '^src/page/' '^src/scan/' '^tests/scan_made_files\.h$'
only_in '^stb/' '^src/image/canvas\.'
only_in '^(GLFW/|imgui|backends/imgui)' '^src/view/' '^tests/(viewer_hands\.h|parameter_panel_test\.cpp)$'
only_in '^nettle/' '^src/study/'
only_in '^mpi\.h' '^src/team/mpi/'
only_in '^gtest/' '^tests/'
only_in '^pybind11/' '^src/python/'

# --- components, from the ground floor up: each may include those before it -------------------------
# A line: the component, then its public headers in include/psivox.
floors=$(
  cat <<'LIST'
base error
colour
team team
guard
field field value_scale
scan
vdb vdb
reader
scene camera integrators modes parameters scene
atlas
medium medium
image image picture_file
oiio
march marcher
gl
reference
plan
draw draw
look open
app file_report
page page
sequence sequence
verify verify
study study
view
python
LIST
)
declare -A floor_of  # of a component and of a public header
floor=0
while read -r component headers; do
  floor_of[$component/]=$floor
  for header in $headers; do floor_of[psivox/$header.h]=$floor; done
  floor=$((floor + 1))
done <<<"$floors"
for place in src/*/ include/psivox/*.h; do
  name=${place#src/}
  [ -n "${floor_of[${name#include/}]-}" ] ||
    complain "$place" "tests/check_includes.sh does not list it"
done
while read -r place header; do
  file=${place%%:*}
  case $file in
    include/*) own=${file#include/} ;;
    *) own=${file#src/} own=${own%%/*}/ ;;
  esac
  [[ $header == psivox/* ]] && other=$header || other=${header%%/*}/
  if [[ $header == ../* || $header == */../* ]]; then
    complain "$place" "$header: includes start at include/, src/ or shaders/"
  elif [ -n "${floor_of[$other]-}" ] && ((floor_of[$other] > floor_of[$own])); then
    complain "$place" "${own%/} must not include $header, which is above it"
  fi
done < <(includes include src)

# The reference is a different algorithm. It shares no shader, and of march/ only the view of the
# light.
while read -r place header; do
  [[ $header == reference/* ]] || continue
  [[ $place == src/reference/* || $place == src/draw/* || $place == src/plan/* || $place == tests/* ]] ||
    complain "$place" "reference/ is for itself, for draw/, plan/ and tests"
done < <(includes "${folders[@]}")
while read -r place header; do
  [[ $header == *.glsl || $header == all_integrators.h ]] || continue
  case $place in
    src/colour/* | src/march/* | src/gl/* | tools/bench/* | tests/*) ;;
    *) complain "$place" "shaders are for src/colour, src/march, src/gl, tools/bench and tests" ;;
  esac
done < <(includes "${folders[@]}")

# --- public headers: psivox/, glm, the standard library --------------------------------------------
while read -r place header; do
  case $header in
    psivox/* | glm/*) ;;
    */* | *.h) complain "$place" "public headers include psivox/, glm/ and the standard library" ;;
  esac
done < <(includes include)

# --- shaders include shaders only ------------------------------------------------------------------
while IFS=: read -r file line text; do
  header=$(sed -E 's/.*#include "([^"]+)".*/\1/' <<<"$text")
  [ "$header" = integrator.glsl ] && continue  # generated for each program
  [ -f "$(dirname "$file")/$header" ] || complain "$file:$line" "no shader $header"
done < <(grep -rn '^#include' shaders || true)
if grep -rnE '\b(gl_[A-Z]|texelFetch|texture(Lod)?[[:space:]]*\(|uniform |layout)' shaders/math shaders/integrators; then
  complain "shaders/math, shaders/integrators" "formulas only: no gl_*, textures, uniforms"
fi

# --- one place prints, and escapes what controls a terminal ----------------------------------------
while IFS=: read -r file line _; do
  case $file in
    src/base/terminal.cpp | tools/make_assets.cpp | tools/bench/* | tools/gpu_cost/*) ;;
    *) complain "$file:$line" "base/terminal.h prints" ;;
  esac
done < <(grep -rnE --include='*.cpp' --include='*.h' '\b(printf|puts|putchar|perror) *\(|std::cerr|(fprintf|fputs)\(.*std(out|err)' src tools |
  grep -vE '\\033\[K|gnu::format' || true)

[ $bad = 0 ] && echo "includes: all in their direction"
exit $bad
