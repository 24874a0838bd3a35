#!/usr/bin/env bash
# Installs everything that psivox needs to build, run and pass its tests on Debian 12. Returns
# quickly if all is installed. --ci adds the checkers that .ci/run uses, and a display for the
# tests.
set -euo pipefail

packages=(
  # build
  g++ cmake ninja-build ccache pkg-config
  # libraries: OpenVDB, images, maths, threads, GL without a window, the viewer's window
  # (libopenvdb-dev does not depend on the Boost headers that its own headers include)
  libopenvdb-dev libnanovdb-dev libboost-dev libblosc-dev libimath-dev libtbb-dev
  # (OpenImageIO's CMake package does not load without the programs of openimageio-tools)
  libopenimageio-dev openimageio-tools libopenexr-dev libpng-dev zlib1g-dev
  libglm-dev
  libepoxy-dev libegl-dev
  libglfw3-dev libimgui-dev
  libcli11-dev nlohmann-json3-dev libpugixml-dev
  libseccomp-dev
  # SHA-256 of a study's input
  nettle-dev
  # the plots of a study's page; the text of colour bars
  libstb-dev fonts-dejavu-core
  # the Python package
  pybind11-dev python3-dev python3-numpy
  # packages of psivox
  file dpkg-dev
  # tests
  libgtest-dev libnanovdb-tools python3-pytest
  # EGL, and Mesa's software renderer for machines without a GPU
  libegl1 libgl1-mesa-dri
  # GL of a window (GLFW loads these libraries at run time)
  libgl1 libglx-mesa0
)

fail() {
  printf 'install-deps.sh: %s\n' "$1" >&2
  exit 1
}

case "${1-}" in
  "") ;;
  --ci) packages+=(clang-format clang-tidy
    # a display for the window's tests, a browser for the pages'; without them these are skipped
    xvfb xauth chromium chromium-driver python3 python3-matplotlib
    python3-openvdb
    # what programs cost on GPUs (docs/gpu.md): compilers for GPUs that need not be there
    libvulkan-dev glslang-dev glslang-tools spirv-tools mesa-vulkan-drivers
    # the bundle
    libopengl0 patchelf
    # one picture by several processes, under both MPIs
    openmpi-bin libopenmpi-dev mpich libmpich-dev) ;;
  -h | --help)
    printf 'Usage: tools/install-deps.sh [--ci]\nInstalls with apt-get: %s\n' "${packages[*]}"
    printf '%s\n' '--ci adds clang-format, clang-tidy, Xvfb, Chromium, MPI and shader compilers.'
    exit 0
    ;;
  *) fail "unknown argument '$1'; the only one is --ci" ;;
esac

if ! command -v apt-get >/dev/null || ! command -v dpkg-query >/dev/null; then
  fail "no apt-get here: this script is for Debian; install the likes of: ${packages[*]}"
fi

installed=$(dpkg-query -W -f='${Package} ${db:Status-Status}\n' "${packages[@]}" 2>/dev/null || true)
missing=()
for package in "${packages[@]}"; do
  grep -qxF "$package installed" <<<"$installed" || missing+=("$package")
done
if ((${#missing[@]} == 0)); then
  echo "install-deps.sh: all ${#packages[@]} packages are installed"
  exit 0
fi

as_root=()
if ((EUID != 0)); then
  command -v sudo >/dev/null ||
    fail "not root and no sudo; as root, run: apt-get install ${missing[*]}"
  as_root=(sudo)
  [[ -t 0 ]] || as_root+=(-n)  # no terminal, so nobody to type a password
fi
apt() {
  "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive \
    apt-get -qq -o DPkg::Lock::Timeout=300 -o Dpkg::Use-Pty=0 "$@" </dev/null
}

echo "install-deps.sh: installing ${missing[*]}"
# A broken third-party source may not matter; the installation below fails if packages are missing.
apt update || echo "install-deps.sh: apt-get update failed; going on with the lists at hand" >&2
apt install --yes --no-install-recommends "${missing[@]}" ||
  fail "apt-get could not install: ${missing[*]}"
