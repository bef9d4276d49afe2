#!/bin/bash
# Prepares a bare Debian 12 for building, testing and running segcal. As root or with sudo; needs no input; a second run finds
# everything done and takes about a second. Changes nothing outside the source tree except the packages it installs.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

packages=(
  g++ cmake ninja-build git ca-certificates dpkg-dev
  libeigen3-dev                                # the core
  libopencv-dev libceres-dev libcli11-dev libyaml-cpp-dev nlohmann-json3-dev libssl-dev   # the host program
  libbenchmark-dev libopenblas0 liblapack3     # benchmarks, and LAPACK's QR beside the core's
  clang-format clang-tidy                      # tests: all files, and the lines that changed
  python3-venv python3-dev                     # plots, readers of logs, the fleet, evo for a test; the Python wheel
  chromium chromium-driver                     # the report's test: pages drawn in a browser
  gcc-arm-none-eabi libnewlib-arm-none-eabi libstdc++-arm-none-eabi-dev qemu-system-arm   # firmware images, and where they run
  g++-aarch64-linux-gnu qemu-user pkg-config   # the same for 64-bit Arm; the installed library's test
)

is_installed() {
  [ "$(dpkg-query -W -f '${db:Status-Status}' "$1" 2> /dev/null)" = installed ]
}

as_root() {
  if [ "$(id -u)" -eq 0 ]; then "$@"; else sudo --preserve-env=DEBIAN_FRONTEND "$@"; fi
}

install_packages() {
  local package missing=()
  for package in "${packages[@]}"; do
    is_installed "$package" || missing+=("$package")
  done
  [ "${#missing[@]}" -eq 0 ] && return
  echo "Installing: ${missing[*]}"
  export DEBIAN_FRONTEND=noninteractive
  as_root apt-get -q -o Acquire::Retries=3 update
  as_root apt-get -q -y -o Acquire::Retries=3 install --no-install-recommends "${missing[@]}"
}

# .venv holds a copy of the list it was made from: a changed list makes it anew, an interrupted run too.
make_python_environment() {
  local list=host_tools/report/requirements.txt
  cmp -s "$list" .venv/requirements.txt && return
  echo "Making .venv from $list"
  rm -rf .venv
  python3 -m venv .venv
  .venv/bin/pip install --quiet --disable-pip-version-check -r "$list"
  cp "$list" .venv/requirements.txt
}

# For the test of the PlatformIO package; apart from .venv, since it pins what others want newer.
make_platformio_environment() {
  local versions="platformio==6.2.0 scons==4.11.1" home=third_party/platformio
  [ "$(cat "$home/versions" 2> /dev/null)" = "$versions" ] && return
  echo "Making $home"
  rm -rf "$home"
  python3 -m venv "$home"
  # shellcheck disable=SC2086
  "$home/bin/pip" install --quiet --disable-pip-version-check $versions
  echo "$versions" > "$home/versions"
}

# Where Unity's own repository can be reached, CMake fetches it from there.
prepare_unity() {
  [ -e third_party/unity/unity.c ] && return
  local repository=https://github.com/ThrowTheSwitch/Unity.git
  GIT_TERMINAL_PROMPT=0 timeout 8 git ls-remote --exit-code "$repository" refs/tags/v2.6.0 > /dev/null 2>&1 && return
  host_tools/fetch_unity.sh "$PWD/third_party/unity"
}

# The pictures on the walls of rendered rooms (`segcal simulate --images`): scikit-image's example photographs, of which the
# wheel is taken apart and nothing else is used.
prepare_photographs() {
  [ -d third_party/photographs ] && return
  local work
  work=$(mktemp -d)
  .venv/bin/pip download --quiet --disable-pip-version-check --no-deps --only-binary :all: -d "$work" scikit-image==0.26.0
  .venv/bin/python -m zipfile -e "$work"/scikit_image-*.whl "$work/wheel"
  mkdir -p third_party "$work/photographs"
  cp "$work"/wheel/skimage/data/*.png "$work"/wheel/skimage/data/*.jpg "$work/photographs"
  mv "$work/photographs" third_party/photographs
  rm -rf "$work"
}

install_packages
make_python_environment
make_platformio_environment
prepare_unity
prepare_photographs
echo "Ready. Next: cmake --workflow --preset demo, --preset test or --preset firmware"
