#!/usr/bin/env bash
# run.sh PYTHON PACKAGES PROGRAM ASSETS: runs the tests of the Python package.
set -euo pipefail
python=$1
export PYTHONPATH=$2 PSIVOX_PROGRAM=$3 PSIVOX_ASSETS=$4 PYTHONDONTWRITEBYTECODE=1
if ! "$python" -c 'import numpy, pytest' 2>/dev/null; then
  echo "skipped: $python has no numpy or pytest (Debian: python3-numpy python3-pytest)"
  exit 77
fi
if ! "$python" -c 'import psivox, sys; sys.exit(all(d["problem"] for d in psivox.devices()))'; then
  echo "skipped: no EGL device"
  exit 77
fi
exec "$python" -m pytest -q -p no:cacheprovider "$(dirname "$0")" "${@:5}"
