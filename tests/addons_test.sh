#!/usr/bin/env bash
# Draws by the add-ons of other programs: addons_test.sh PSIVOX ASSETS. Skips (exit 77) without any
# of these programs, or without an EGL device.
tested= assets=$2 here=$(cd "$(dirname "$0")" && pwd)
. "$here/cli_setup.sh"
tried=0
PATH=$(dirname "$program"):$PATH
if command -v blender >/dev/null; then
  tried=1
  said=$(HOME=$work blender -b --factory-startup --python-exit-code 1 --python "$here/addon_blender.py" -- \
    "$here/../tools/addons/psivox_blender.py" "$program" "$assets/blobs.vdb" 2>&1)
  [ $? -eq 0 ] && grep -q "the add-on draws as" <<<"$said" || fail "Blender: $(tail -n 12 <<<"$said")"
fi
if command -v pvpython >/dev/null; then
  tried=1
  said=$(HOME=$work pvpython --force-offscreen-rendering "$here/addon_paraview.py" \
    "$here/../tools/addons/psivox_paraview.py" "$program" 2>&1)
  [ $? -eq 0 ] && grep -q "the macro draws as" <<<"$said" || fail "ParaView: $(tail -n 12 <<<"$said")"
fi
[ $tried = 1 ] || { echo "skipped: no blender, no pvpython"; exit 77; }
[ $failed -eq 0 ]
