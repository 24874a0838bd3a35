#!/usr/bin/env bash
# Tries the bundle of tools/make-bundle.sh where nothing is installed: tools/check-bundle.sh SUITE...
# In a clean root of each Debian (bookworm, trixie, forky, ...), without a package added and not as
# root, it unpacks the .run and draws, studies, makes a page, and opens the window on a display of
# this machine. Needs root, mmdebstrap and Xvfb. PSIVOX_ROOTS: as for tools/check-debian.sh.
# The suite `empty` is a root of glibc alone, in which the folder draws; it needs root.
set -euo pipefail
cd "$(dirname "$0")/.."
fail() {
  printf 'check-bundle.sh: %s\n' "$1" >&2
  exit 1
}
if [[ ${1-} == empty ]]; then
  root=$(mktemp -d)
  trap 'rm -rf "$root"' EXIT
  mkdir -p "$root"/{lib64,lib/x86_64-linux-gnu,proc,tmp}
  cp -L /lib64/ld-linux-x86-64.so.2 "$root/lib64/"
  cp -L /lib/x86_64-linux-gnu/lib{c,m,dl,rt,pthread}.so.? "$root/lib/x86_64-linux-gnu/"
  cp -a build/bundle/psivox-*/ "$root/psivox"
  cp assets/blobs.vdb "$root/tmp/"
  unshare -m bash -euo pipefail -c 'mount --bind /proc "$1/proc"
    env -i /usr/sbin/chroot "$1" /psivox/psivox render /tmp/blobs.vdb -o /tmp/x.png --resolution 64x64
    env -i /usr/sbin/chroot "$1" /psivox/psivox --version' - "$root"
  [[ -s $root/tmp/x.png ]] && echo "the bundle draws in a root of glibc alone"
  exit
fi
runs=(build/bundle/*.run)
[[ -e ${runs[0]} ]] || fail "no build/bundle/*.run; tools/make-bundle.sh makes it"
[[ $# -gt 0 ]] || fail "usage: tools/check-bundle.sh SUITE..."
roots=${PSIVOX_ROOTS:-/var/tmp/psivox-roots}
mkdir -p "$roots"
Xvfb :88 -ac -screen 0 1280x800x24 >/dev/null 2>&1 &
server=$!
trap 'kill $server' EXIT

for suite in "$@"; do
  root=$roots/clean-$suite
  [[ -e $root/usr/bin/apt-get ]] ||
    mmdebstrap --variant=minbase --aptopt='Acquire::Check-Valid-Until "false"' "$suite" "$root"
  rm -rf "$root/srv/try" && mkdir -m 777 "$root/srv/try"
  cp "${runs[0]}" "$root/srv/try/psivox.run"
  cat >"$root/srv/try/script" <<'EOF'
set -euo pipefail
said() {  # said CODE TEXT COMMAND...
  local code=0 text
  text=$("${@:3}" 2>&1) || code=$?
  [[ $code == "$1" && $text == *"$2"* ]] || { echo "FAILED: ${*:3}: exit $code: $text"; exit 1; }
}
start=${EPOCHREALTIME/./}
since() { echo "  $(((${EPOCHREALTIME/./} - start) / 1000)) ms: $1"; }
sh psivox.run >unpacked.txt 2>&1
since "unpacked; $(grep '^GL ' unpacked.txt)"
cd psivox-*/
p=$PWD/psivox
said 0 "look smoke" "$p" examples -o ../examples
since "five pictures"
cd ../examples
said 0 "" "$p" render blobs.vdb -o page.html --resolution 320x180
said 0 "" "$p" study blobs.vdb -o study --resolution 48x48 --integrators psi-weighted --steps 1 --no-split
[[ -s study/index.html && -s page.html ]]
said 5 "ffmpeg is not installed" "$p" render blobs.vdb -o 't.##.png' --turntable 2 --resolution 64x64 --movie t.mp4
said 5 ".exr and .png need none" "$p" render blobs.vdb -o x.tif --resolution 64x64
said 2 "draws it" env -u DISPLAY "$p" blobs.vdb
said 0 "refined" env XDG_STATE_HOME=/srv/try "$p" view blobs.vdb --benchmark-orbit 8
said 0 "all passed" "$p" verify
since "page, study, window, verify"
# all that is loaded is glibc's, the bundle's, or the system's in place of the bundle's fallback
for file in "${p%/*}/bin/psivox" $(find "${p%/*}/lib" -name '*.so*'); do ldd "$file"; done |
  awk -v own="${p%/*}/" '/not found/ { print $1, "missing" }
    $3 ~ "^/" && index($3, own) != 1 { print $1, $3 }' | sort -u |
  while read -r name path; do
    [[ $path != missing && ($name =~ ^lib(c|m|dl|rt|pthread)\.so || -e ${p%/*}/lib/fallback/$name) ]] ||
      { echo "FAILED: $name is $path"; exit 1; }
  done
EOF
  printf '%s\n' "$suite:"
  unshare -m bash -euo pipefail -c 'root=$1
    mkdir -p "$root/tmp/.X11-unix"
    mount --bind /proc "$root/proc" && mount --bind /dev "$root/dev"
    mount --bind /tmp/.X11-unix "$root/tmp/.X11-unix"
    exec chroot --userspec=65534:65534 "$root" /usr/bin/env -i HOME=/srv/try DISPLAY=:88 \
      PATH=/usr/bin:/bin /bin/bash -c "cd /srv/try && exec bash script"' - "$root"
done
echo "the bundle works in: $*"
