#!/usr/bin/env bash
# Checks that every test named in docs/precision.md and docs/formats.md exists.
# check_stability.sh [ROOT]
set -euo pipefail
cd "${1:-$(dirname "$0")/..}"
rows=0 bad=0
for page in docs/precision.md docs/formats.md; do
  while IFS=. read -r suite name; do
    rows=$((rows + 1))
    grep -qE "^(TYPED_)?TEST(_F|_P)?\($suite, $name\)" tests/*_test.cpp ||
      { echo "$page: no test $suite.$name" >&2; bad=1; }
  done < <(grep -E '^\|' $page | grep -oE '`[A-Z][A-Za-z]+\.[A-Z][A-Za-z0-9]+`' | tr -d '`')
done
((rows >= 55)) || { echo "docs: $rows tests named, expected 55 at least" >&2; bad=1; }
[ $bad = 0 ] && echo "all $rows tests that docs/precision.md and docs/formats.md name exist"
exit $bad
