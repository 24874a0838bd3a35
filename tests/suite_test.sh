#!/usr/bin/env bash
# Runs the precision suite as its users do: suite_test.sh PSIVOX. Its exit code tells whether every
# order and error is as it must be. Without an EGL device it skips (exit 77).
tests=$(cd "$(dirname "$0")" && pwd) tested=study
. "$tests/cli_setup.sh"

run 2 "small" --suite=huge -o bad
run 4 "--list-devices" --suite --device 99 -o bad -q
run 0 ": all as expected." --suite -o suite
for file in suite.csv suite.json index.html spheres.png step.json; do
  [ -s "suite/$file" ] || fail "no $file"
done
# a row for each picture, of as many numbers as the head has names
awk -F, 'NR == 1 { n = NF } NF != n { exit 1 } END { exit NR != 316 }' suite/suite.csv ||
  fail "suite.csv: not 315 rows of equal length"
grep -q "NOT AS EXPECTED" suite/suite.json && fail "suite.json has what the exit code denies"
if type chromium chromedriver python3 >/dev/null 2>&1; then  # what a browser shows of its page
  python3 "$tests/page_test.py" "$work" || failed=$((failed + 1))
fi
exit $((failed > 0))
