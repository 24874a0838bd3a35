#!/usr/bin/env bash
# Makes the Debian packages and checks them as a user would meet them: lintian, then an installation
# in a clean Debian 12 in a folder, where psivox renders, makes a thumbnail in a sandbox, completes
# an option and shows its manual; a program is built with libpsivox-dev. Needs root, and mmdebstrap,
# lintian, desktop-file-utils, appstream, shared-mime-info and bubblewrap.
set -euo pipefail
cd "$(dirname "$0")/.."
root=$(mktemp -d)
trap 'rm -rf "$root"' EXIT
fail() {
  printf 'check-packages.sh: %s\n' "$1" >&2
  exit 1
}
stage() { printf '\n== %s\n' "$1"; }

stage "packages"
cmake --preset package
cmake --build --preset package
rm -rf build/package/packages
cpack --preset package
packages=(build/package/packages/*.deb)

stage "lintian"
lintian --allow-root --fail-on error "${packages[@]}"
desktop-file-validate assets/desktop/*.desktop
appstreamcli validate --no-net build/package/*.metainfo.xml

stage "a clean Debian 12"
chmod 755 "$root"
mmdebstrap --variant=minbase --skip=cleanup/apt bookworm "$root/debian"
cp /etc/resolv.conf "$root/debian/etc/"
mkdir "$root/debian/work"
cp "${packages[@]}" assets/blobs.vdb "$root/debian/work/"
cp -r tests/package "$root/debian/work/consumer"
run() { chroot "$root/debian" /bin/bash -euo pipefail -c "cd /work && $1"; }
mount --bind /proc "$root/debian/proc"
trap 'umount "$root/debian/proc"; rm -rf "$root"' EXIT
# man's pages are left out of small images
run "rm -f /etc/dpkg/dpkg.cfg.d/* && export DEBIAN_FRONTEND=noninteractive &&
  apt-get install -y ./psivox_*.deb man-db shared-mime-info bash-completion >install.log"

stage "render"
run "psivox --version && psivox render blobs.vdb -o blobs.png --resolution 256x256 && ls -l blobs.png"

stage "manual and completion"
run "man psivox-render | head -n 12"
run ". /usr/share/bash-completion/completions/psivox
  COMP_WORDS=(psivox render --mode is) COMP_CWORD=3; _psivox; echo \"\${COMPREPLY[*]}\"" |
  grep -x isosurface

stage "file type and thumbnail"
run "grep -x 'application/vnd.vdb:\*.vdb' /usr/share/mime/globs && grep -q BDV /usr/share/mime/magic" ||
  fail "the file type is not known"
# as GNOME's file manager calls it: without a network, with a read-only /usr and no home
mapfile -t command < <(sed -n 's/^Exec=//p' assets/desktop/psivox.thumbnailer | tr ' ' '\n' |
  sed 's:%i:/volume.vdb:; s:%o:/tmp/thumbnail.png:; s:%s:256:')
bwrap --ro-bind "$root/debian/usr" /usr --symlink usr/bin /bin --symlink usr/lib /lib \
  --symlink usr/lib64 /lib64 --ro-bind "$root/debian/etc/ld.so.cache" /etc/ld.so.cache \
  --proc /proc --dev /dev --bind "$root/debian/work" /tmp --ro-bind assets/blobs.vdb /volume.vdb \
  --unshare-all --clearenv --setenv PATH /usr/bin "${command[@]}"
run "ls -l thumbnail.png"

stage "a program that uses libpsivox-dev"
run "apt-get install -y ./libpsivox-dev_*.deb g++ cmake make pkg-config >>install.log &&
  cmake -S consumer -B consumer/build >>install.log && cmake --build consumer/build >>install.log &&
  ctest --test-dir consumer/build | tail -n 3 &&
  g++ -std=c++20 consumer/consumer.cpp -o with_pkg_config \$(pkg-config --cflags --libs psivox) &&
  ./with_pkg_config"

if [ -e build/package/packages/python3-psivox_*.deb ]; then
  stage "Python"
  run "apt-get install -y ./python3-psivox_*.deb >>install.log &&
    python3 -c \"import psivox, numpy as np; psivox.render(np.random.rand(64, 64, 64).astype('f4')).write('x.png')\" &&
    ls -l x.png"
fi
echo "all packages pass"
