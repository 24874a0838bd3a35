#!/usr/bin/env bash
# Tests the page of a study in headless Chromium: page_test.sh PSIVOX ASSETS. Without an EGL device,
# Chromium, its driver or Python it skips (exit 77).
set -u
program=$1 assets=$2
for needed in chromium chromedriver python3; do
  if ! command -v $needed >/dev/null; then
    echo "no $needed: skipped"
    exit 77
  fi
done
if ! "$program" render --list-devices | grep -q "4\.[5-9]"; then
  echo "no EGL device: skipped"
  exit 77
fi
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

"$program" study "$assets/blobs.vdb" -o "$work/study" -q --luminance-grid density --resolution 64x48 \
  --repeats 1 --no-split --integrators porter-duff,psi-exact,cell-exact --segments 1,2 --steps 2,1,0.5 &&
  "$program" study --summary "$work/study" -o "$work/summary" -q &&
  python3 "$(dirname "$0")/page_test.py" "$work"
