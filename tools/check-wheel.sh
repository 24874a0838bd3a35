#!/usr/bin/env bash
# Tries the wheels of tools/make_wheel.py: tools/check-wheel.sh SUITE...
# In a clean root of each Debian with its Python and numpy it installs the wheel for that Python into
# a new virtual environment and draws, by the module and by the program. Needs root and mmdebstrap.
set -euo pipefail
cd "$(dirname "$0")/.."
roots=${PSIVOX_ROOTS:-/var/tmp/psivox-roots}
mkdir -p "$roots"
[[ $# -gt 0 ]] || { echo "usage: tools/check-wheel.sh SUITE..." >&2; exit 2; }
for suite in "$@"; do
  root=$roots/python-$suite
  [[ -e $root/usr/bin/python3 ]] ||
    mmdebstrap --variant=minbase --include=python3-venv,python3-numpy "$suite" "$root"
  rm -rf "$root/srv/try" && mkdir -m 777 "$root/srv/try"
  cp build/bundle/*.whl "$root/srv/try/"
  cat >"$root/srv/try/script" <<'EOF'
set -euo pipefail
start=${EPOCHREALTIME/./}
python3 -m venv --system-site-packages venv  # numpy is the system's
tag=$(python3 -c 'import sys; print("cp%d%d" % sys.version_info[:2])')
venv/bin/pip install --quiet --no-index psivox-*-"$tag"-*.whl
venv/bin/python - <<'PYTHON'
import numpy as np, psivox
x, y, z = np.mgrid[-1:1:32j, -1:1:32j, -1:1:32j]
ball = np.maximum(0, 0.5 - x**2 - y**2 - z**2).astype("f4")
image = psivox.render(ball, resolution=(160, 90))
assert np.asarray(image)[45, 80, 3] > 0.5
image.write("ball.png")
assert "<iframe" in psivox.show(ball, resolution=(160, 90))._repr_html_()
try:
    psivox.info("script")
    raise SystemExit("a damaged file was read")
except psivox.Error as error:
    assert error.exit_code == 3, error
PYTHON
venv/bin/psivox examples -o examples -q
venv/bin/python -m psivox info examples/blobs.vdb | grep -q density
venv/bin/python -m psivox --version | sed -n 's/^GL /  /p'
echo "  $tag: all in $(((${EPOCHREALTIME/./} - start) / 1000)) ms"
EOF
  echo "$suite:"
  unshare -m bash -euo pipefail -c 'mount --bind /proc "$1/proc" && mount --bind /dev "$1/dev"
    exec chroot --userspec=65534:65534 "$1" /usr/bin/env -i HOME=/srv/try PATH=/usr/bin:/bin \
      /bin/bash -c "cd /srv/try && exec bash script"' - "$root"
done
echo "the wheel works in: $*"
