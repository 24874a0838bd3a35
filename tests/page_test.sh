#!/usr/bin/env bash
# Tests the page of a study in headless Chromium: page_test.sh PSIVOX ASSETS. Without an EGL device,
# Chromium, its driver or Python it skips (exit 77).
tests=$(cd "$(dirname "$0")" && pwd) assets=$2
. "$tests/browser_setup.sh"

scene=("$assets/blobs.vdb" -q --luminance-grid density --resolution 64x48)
"$program" render "${scene[@]}" --step 1 -o peer.exr &&
  "$program" study "${scene[@]}" -o "$work/study" --repeats 1 --no-split --steps 2,1,0.5 --segments 1,2 \
    --integrators porter-duff,psi-exact,cell-exact --add "peer 2=peer.exr,7.5" &&
  ln -s "$assets/blobs.vdb" "$work/in.1.vdb" && ln -s "$assets/ramp.vdb" "$work/in.2.vdb" &&
  "$program" study "$work/in.#.vdb" --frames 1-2 -o "$work/frames" -q --resolution 16x12 \
    --repeats 1 --no-split --integrators midpoint --samplings uniform --steps 1 &&
  python3 "$tests/page_test.py" "$work"
