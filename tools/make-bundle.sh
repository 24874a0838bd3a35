#!/usr/bin/env bash
# Makes psivox for any Linux with glibc 2.36 or later: tools/make-bundle.sh [--folder] [BUILD]
# Takes what BUILD (default: build/release) built on Debian 12, and writes to build/bundle a folder
# psivox-VERSION-linux-x86_64 that brings all it needs, and of it a .tar.xz, a .run and a .spdx list
# of its parts; with --folder the folder alone.
#   lib           what psivox needs
#   lib/fallback  what graphics drivers and windows need, too: used where the system has none, so
#                 that the system's own drivers find their own libraries
#   lib/mesa      Mesa's software renderer, for systems without an EGL driver
# OpenImageIO is left out: it brings 250 libraries, some of them under the GPL.
# Needs patchelf, and makeself and xz-utils to pack.
set -euo pipefail
cd "$(dirname "$0")/.."
fail() {
  printf 'make-bundle.sh: %s\n' "$1" >&2
  exit 1
}
pack=1
[[ ${1-} != --folder ]] || { pack=; shift; }
build=${1:-build/release}
[[ -e $build/cmake_install.cmake ]] || fail "no $build: build psivox first"
command -v patchelf >/dev/null || fail "no patchelf (Debian: patchelf)"
version=$(sed -n 's/^project(psivox VERSION \([0-9.]*\).*/\1/p' CMakeLists.txt)
name=psivox-$version-linux-x86_64
out=build/bundle
root=$out/$name
libraries=/usr/lib/x86_64-linux-gnu
rm -rf "$out" && mkdir -p "$out"

DESTDIR='' cmake --install "$build" --prefix "$PWD/$root" --component psivox --strip >"$out/install.log"
rm -f "$root/lib/psivox/libpsivox_oiio.so"
mkdir -p "$root"/lib/{fallback,mesa/dri} "$root/licenses/common"

# closure FILE...: NAME PATH of every library that they load, but for glibc's
closure() {
  ldd "$@" | awk '$3 ~ "^/" { print $1, $3 }' | sort -u |
    grep -vE '^(libc|libm|libdl|librt|libpthread|libresolv|libutil|libanl|libnsl|ld-linux.*)\.so'
}
mesa=(libEGL_mesa.so.0 libGLX_mesa.so.0 libglapi.so.0 libgbm.so.1)
# GLFW loads these when it opens a window
windows=(libX11-xcb.so.1 libXcursor.so.1 libXext.so.6 libXi.so.6 libXinerama.so.1 libXrandr.so.2
  libXrender.so.1 libXxf86vm.so.1)
entries=(libEGL.so.1 libGL.so.1 libGLX.so.0 libGLdispatch.so.0 libOpenGL.so.0)
for file in "${mesa[@]}" "${windows[@]}" "${entries[@]}" dri/swrast_dri.so; do
  [[ -e $libraries/$file ]] || fail "no $file (Debian: libegl1 libgl1 libopengl0 libgl1-mesa-dri libglfw3)"
done
printf '%s\n' "${mesa[@]}" "${entries[@]}" libpsivox.so.0 >"$out/elsewhere"
{
  closure "${mesa[@]/#/$libraries/}" $libraries/dri/swrast_dri.so "${windows[@]/#/$libraries/}"
  for file in "${windows[@]}"; do echo "$file $libraries/$file"; done
} | sort -u | grep -vFf "$out/elsewhere" >"$out/fallback"
closure "$root/bin/psivox" "$root/lib/psivox/libpsivox_reader.so" |
  grep -vFf "$out/elsewhere" | grep -vFf <(cut -d' ' -f1 "$out/fallback") >"$out/own"

while read -r file path; do cp -L "$path" "$root/lib/$file"; done <"$out/own"
while read -r file path; do cp -L "$path" "$root/lib/fallback/$file"; done <"$out/fallback"
for file in "${entries[@]}"; do cp -L "$libraries/$file" "$root/lib/$file"; done
for file in "${mesa[@]}"; do cp -L "$libraries/$file" "$root/lib/mesa/$file"; done
cp -L $libraries/dri/swrast_dri.so "$root/lib/mesa/dri/"
cp /usr/share/glvnd/egl_vendor.d/50_mesa.json "$root/lib/mesa/"
# one file by the name that is looked for, as wheels have no links
mv "$(realpath "$root/lib/libpsivox.so.0")" "$root/lib/libpsivox" && rm -f "$root"/lib/libpsivox.so*
mv "$root/lib/libpsivox" "$root/lib/libpsivox.so.0"
ln -s bin/psivox "$root/psivox"

# Where each looks for libraries: its own, the system's, the fallback.
system=$libraries:/usr/lib64:/usr/lib
find_in() {  # find_in LIB FILE...: LIB is lib as seen from the files
  patchelf --set-rpath "$1:$system:$1/fallback:$1/mesa" "${@:2}"
}
find_in "\$ORIGIN/../lib" "$root/bin/psivox"
find_in "\$ORIGIN" "$root"/lib/*.so*
find_in "\$ORIGIN/.." "$root"/lib/psivox/*.so
patchelf --set-rpath "$system:\$ORIGIN" "$root"/lib/fallback/*
patchelf --set-rpath "\$ORIGIN:$system:\$ORIGIN/../fallback" "$root"/lib/mesa/*.so*
patchelf --set-rpath "\$ORIGIN/..:$system:\$ORIGIN/../../fallback" "$root"/lib/mesa/dri/*

# Licences, and the list of parts: Debian's packages of the libraries, and of what is compiled in.
{
  cut -d' ' -f2 "$out/own" "$out/fallback" | xargs realpath
  for file in "${mesa[@]}" "${entries[@]}" dri/swrast_dri.so; do realpath "$libraries/$file"; done
} | sed 's:^/lib/:/usr/lib/:' | while read -r path; do
  dpkg -S "$path" 2>/dev/null || dpkg -S "${path#/usr}"
done | cut -d: -f1 | cat - <(printf '%s\n' fonts-dejavu-core libstb-dev libimgui-dev libcli11-dev \
  nlohmann-json3-dev libglm-dev libnanovdb-dev) | sort -u >"$out/packages"
while read -r package; do
  cp -L "/usr/share/doc/$package/copyright" "$root/licenses/$package.txt"
done <"$out/packages"
cp /usr/share/common-licenses/{Apache-2.0,BSD,GPL-2,GPL-3,LGPL-2,LGPL-2.1,LGPL-3,MPL-1.1,MPL-2.0} \
  "$root/licenses/common/"
cp LICENSE "$root/LICENSE"
{
  printf '%s\n' "SPDXVersion: SPDX-2.3" "DataLicense: CC0-1.0" "SPDXID: SPDXRef-DOCUMENT" \
    "DocumentName: $name" "DocumentNamespace: urn:psivox:$name" "Creator: Tool: make-bundle.sh" \
    "Created: $(date -u +%FT%TZ)" "" "PackageName: psivox" "SPDXID: SPDXRef-psivox" \
    "PackageVersion: $version" "PackageDownloadLocation: NOASSERTION" \
    "PackageLicenseDeclared: Apache-2.0" \
    "FilesAnalyzed: false" "Relationship: SPDXRef-DOCUMENT DESCRIBES SPDXRef-psivox"
  while read -r package; do
    of=$(dpkg-query -W -f='${Version}' "$package:amd64" 2>/dev/null || dpkg-query -W -f='${Version}' "$package")
    printf '%s\n' "" "PackageName: $package" "SPDXID: SPDXRef-${package//+/-plus}" \
      "PackageVersion: $of" "PackageDownloadLocation: NOASSERTION" \
      "FilesAnalyzed: false" "ExternalRef: PACKAGE-MANAGER purl pkg:deb/debian/$package@$of?distro=debian-12" \
      "Relationship: SPDXRef-psivox CONTAINS SPDXRef-${package//+/-plus}"
  done <"$out/packages"
} >"$out/$name.spdx"
[[ $pack ]] || exit 0

tar -C "$out" --sort=name --owner=0 --group=0 --numeric-owner -c "$name" |
  xz -T0 >"$out/$name.tar.xz"
makeself --nox11 --notemp --gzip --target "$name" "$root" "$out/$name.run" "psivox $version" \
  ./psivox --version >"$out/makeself.log"
du -h --apparent-size "$root" "$out/$name.tar.xz" "$out/$name.run" | grep -v "$root/"
