#!/usr/bin/env bash
# with_display.sh COMMAND...: runs COMMAND on a virtual display. Without Xvfb it exits with 77,
# which ctest counts as skipped.
if ! command -v xvfb-run >/dev/null || ! command -v Xvfb >/dev/null; then
  echo "skipped: no Xvfb (Debian: xvfb xauth)"
  exit 77
fi
state=$(mktemp -d)
trap 'rm -rf "$state"' EXIT
XDG_STATE_HOME=$state xvfb-run -a -s "-screen 0 1600x1000x24 -noreset" "$@"
