#!/usr/bin/env bash
# Tests `psivox render -o page.html`: turning_page_test.sh PSIVOX ASSETS. What it refuses; and, in
# headless Chromium with its own OpenGL driver, what its pages draw. Without an EGL device, Chromium,
# its driver or Python it skips (exit 77).
tests=$(cd "$(dirname "$0")" && pwd) assets=$2
tested=render
. "$tests/browser_setup.sh"

R="-q --resolution 64x64"
S=$assets/rotated.vdb
run 2 "a page (.html) has no --filter hardware" "$S" -o a.html $R --filter hardware
run 2 "a page (.html) has no --color-bar" "$S" -o a.html $R --color-bar
run 2 "--aov needs an .exr" "$S" -o a.html $R --aov depth
run 2 "not a sequence" "$S" -o a.html $R --turntable 4
run 2 "not a sequence" "$S" "$S" -o 'a.####.html' $R
run 2 "--credit is for a page" "$S" -o a.png $R --credit me
run 2 "--page-limit is for a page" "$S" -o a.png $R --page-limit 3
run 2 "above --page-limit 0.1" "$S" -o a.html $R --page-limit 0.1
run 6 "parts" "$S" -o a.html $R --memory-limit 1MiB
[ -e a.html ] && fail "a refused page was written"

python3 "$tests/turning_page_test.py" "$program" "$assets" "$work" || failed=$((failed + 1))
[ $failed = 0 ] && echo "pages turn"
exit $failed
