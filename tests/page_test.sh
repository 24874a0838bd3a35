#!/usr/bin/env bash
# Tests the page of a study in headless Chromium: page_test.sh PSIVOX ASSETS. Without an EGL device,
# Chromium, its driver or Python it skips (exit 77).
tests=$(cd "$(dirname "$0")" && pwd) assets=$2
. "$tests/browser_setup.sh"

"$program" study "$assets/blobs.vdb" -o "$work/study" -q --luminance-grid density --resolution 64x48 \
  --repeats 1 --no-split --integrators porter-duff,psi-exact,cell-exact --segments 1,2 --steps 2,1,0.5 &&
  ln -s "$assets/blobs.vdb" "$work/in.1.vdb" && ln -s "$assets/ramp.vdb" "$work/in.2.vdb" &&
  "$program" study "$work/in.#.vdb" --frames 1-2 -o "$work/frames" -q --resolution 16x12 \
    --repeats 1 --no-split --integrators midpoint --samplings uniform --steps 1 &&
  python3 "$tests/page_test.py" "$work"
