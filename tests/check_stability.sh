#!/usr/bin/env bash
# Checks that every test named in docs/stability.md exists. check_stability.sh [ROOT]
set -euo pipefail
cd "${1:-$(dirname "$0")/..}"
rows=0 bad=0
while IFS=. read -r suite name; do
  rows=$((rows + 1))
  grep -qE "^(TYPED_)?TEST(_F|_P)?\($suite, $name\)" tests/*_test.cpp ||
    { echo "docs/stability.md: no test $suite.$name" >&2; bad=1; }
done < <(grep -E '^\|' docs/stability.md | grep -oE '`[A-Z][A-Za-z]+\.[A-Z][A-Za-z]+`' | tr -d '`')
((rows >= 25)) || { echo "docs/stability.md: $rows tests named, expected 25 at least" >&2; bad=1; }
[ $bad = 0 ] && echo "all $rows tests that docs/stability.md names exist"
exit $bad
