#!/usr/bin/env bash
# with_display.sh COMMAND...: runs it on a display of its own, in memory; 77, which ctest takes for
# skipped, where there is no Xvfb.
if ! command -v xvfb-run >/dev/null || ! command -v Xvfb >/dev/null; then
  echo "skipped: no Xvfb (Debian: xvfb xauth)"
  exit 77
fi
state=$(mktemp -d)
trap 'rm -rf "$state"' EXIT
XDG_STATE_HOME=$state xvfb-run -a -s "-screen 0 1600x1000x24 -noreset" "$@"
