#!/usr/bin/env bash
# Runs the precision suite as its users do: suite_test.sh PSIVOX. Its exit code tells whether every
# order and error is as it must be. Without an EGL device it skips (exit 77).
tested=study
. "$(dirname "$0")/cli_setup.sh"

run 2 "small" --suite=huge -o bad
run 4 "--list-devices" --suite --device 99 -o bad -q
run 0 ": all as expected." --suite -o suite
for file in suite.csv suite.md index.html gaussian.svg spheres.png step.json suite-values.svg; do
  [ -s "suite/$file" ] || fail "no $file"
done
# a row for each picture, of as many numbers as the head has names
awk -F, 'NR == 1 { n = NF } NF != n { exit 1 } END { exit NR != 316 }' suite/suite.csv ||
  fail "suite.csv: not 315 rows of equal length"
grep -q "NOT AS EXPECTED" suite/suite.md && fail "suite.md has what the exit code denies"
grep -oE ' (src|href)="[^"]{0,9}|url\(' suite/index.html | grep -vE '"data:|\.svg|href="(suite|gaussian|inside|ramp|rotated|voxel|sphere|tube|step|opaque|gradient|marschner)' &&
  fail "index.html asks for files"
exit $((failed > 0))
