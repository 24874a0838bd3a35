#!/usr/bin/env bash
# Checks that docs/install.md lists every option of the build. check_options.sh [ROOT]
set -euo pipefail
cd "${1:-$(dirname "$0")/..}"
options=0 bad=0
while read -r name; do
  options=$((options + 1))
  grep -qF "\`$name\`" docs/install.md || { echo "docs/install.md: no option $name" >&2; bad=1; }
done < <(cat CMakeLists.txt cmake/*.cmake |
  grep -oE '^ *((psivox_option|option|find_file|find_path|find_library)\([A-Z0-9_]+|set\([A-Z_]+ .* CACHE)' |
  sed -E 's/^ *[a-z_]+\(([A-Z0-9_]+).*/\1/' | sort -u)
((options >= 18)) || { echo "$options options found, expected 18 at least" >&2; bad=1; }
[ $bad = 0 ] && echo "docs/install.md lists all $options options"
exit $bad
