#!/usr/bin/env bash
# Tries psivox on another Debian: tools/check-debian.sh SUITE [--build-only]
# Makes a clean root of SUITE (trixie, forky, ...) with debootstrap, runs both of the README's
# commands there on the last commit, compares the default pictures of three files with those of this
# machine's build/release/bin/psivox, and prints rows for docs/gpu.md. --build-only leaves the
# tests out. Needs root and debootstrap. PSIVOX_ROOTS names the folder of roots (default:
# /var/tmp/psivox-roots); a root is used again if it is there, so that a second run is short.
set -euo pipefail
cd "$(dirname "$0")/.."
fail() {
  printf 'check-debian.sh: %s\n' "$1" >&2
  exit "${2-1}"
}
suite=${1-}
[[ $suite =~ ^[a-z]+$ ]] || fail "usage: tools/check-debian.sh SUITE [--build-only]" 2
[[ ${2-} == "" || ${2-} == --build-only ]] || fail "unknown option '$2'" 2
here=$PWD/build/release/bin/psivox
[[ -x $here ]] || fail "no $here: build psivox here first, to compare with"
root=${PSIVOX_ROOTS:-/var/tmp/psivox-roots}/$suite
stage() { printf '\n== %s (%d s)\n' "$1" "$SECONDS"; }

stage "a root of $suite"
if [[ ! -e $root/usr/bin/apt-get || ! -e $root/etc/complete ]]; then
  rm -rf --one-file-system "$root"
  mkdir -p "$root"
  scripts=${DEBOOTSTRAP_DIR:-/usr/share/debootstrap}/scripts
  script=$scripts/$suite
  [[ -e $script ]] || script=$scripts/sid  # of a suite that is younger than this debootstrap
  debootstrap --variant=minbase --include=ca-certificates,git "$suite" "$root" "" "$script"
  # a mirror of a suite in the making may be days behind
  echo 'Acquire::Check-Valid-Until "false";' >"$root/etc/apt/apt.conf.d/90mirror"
  touch "$root/etc/complete"
fi
cp /etc/resolv.conf "$root/etc/"
mounted=()
unmount() { for folder in "${mounted[@]}"; do umount "$root/$folder"; done; }
trap unmount EXIT
for folder in proc sys dev dev/pts dev/shm; do
  mountpoint -q "$root/$folder" && continue
  mount --bind "/$folder" "$root/$folder"
  mounted=("$folder" "${mounted[@]}")  # the innermost is unmounted first
done
run() { chroot "$root" /usr/bin/env -i HOME=/root PATH=/usr/bin:/bin:/usr/sbin:/sbin LANG=C.UTF-8 \
  /bin/bash -euo pipefail -c "cd /srv/psivox && $1"; }

stage "psivox"
mkdir -p "$root/srv/psivox" "$root/srv/shared"
# not the build: files that an earlier commit had would be compiled with the others
find "$root/srv/psivox" -mindepth 1 -maxdepth 1 ! -name build -exec rm -rf {} +
git archive HEAD | tar -x -C "$root/srv/psivox"
[[ -d ../shared/data ]] && cp -a ../shared/data "$root/srv/shared/"

stage "the README's first command"
run "$(tools/set-up-command.sh 1)"
if [[ ${2-} == "" ]]; then
  stage "the README's second command"
  tests=passed
  run "$(tools/set-up-command.sh 2)" || tests=FAILED
else
  tests="not run"
fi

stage "verify and pictures"
verified=$(run "build/release/bin/psivox verify" | tail -n 1) || verified="FAILED: $verified"
pictures=""
for file in assets/blobs.vdb ../shared/data/{smoke,mri_t1}.vdb; do
  [[ -e $file ]] || continue
  "$here" render "$file" -o "$root/srv/here.exr" -q
  run "build/release/bin/psivox render $file -o ../there.exr -q"
  rms=$("$here" compare "$root/srv/here.exr" "$root/srv/there.exr" | grep -oiE 'rms[ :]+[0-9.e+-]+' |
    head -n 1)
  pictures+="$(basename "$file" .vdb) $rms; "
done

stage "versions"
run 'printf "%s\n" "$(g++ --version | head -n 1)" "$(cmake --version | head -n 1)"
  dpkg-query -W libopenvdb-dev libopenimageio-dev libimgui-dev libcli11-dev libgl1-mesa-dri'
printf '\n| %s | tests %s | verify: %s | %s |\n' "$suite" "$tests" "$verified" "${pictures%; }"
