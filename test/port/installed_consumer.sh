#!/bin/bash
# Installs the library and builds a C program against what was installed: by find_package, and by pkg-config where that is there.
#
# usage: installed_consumer.sh CMAKE BUILD_FOLDER CONSUMER_FOLDER WORK_FOLDER
set -euo pipefail
[ $# -eq 4 ] || { echo "usage: $0 CMAKE BUILD_FOLDER CONSUMER_FOLDER WORK_FOLDER" >&2; exit 2; }
cmake=$1
build=$2
consumer=$3
work=$4
rm -rf "$work"
"$cmake" --install "$build" --prefix "$work/prefix" > /dev/null
"$cmake" -G Ninja -S "$consumer" -B "$work/build" -DCMAKE_PREFIX_PATH="$work/prefix" > /dev/null
"$cmake" --build "$work/build" > /dev/null
"$work/build/consumer"
echo "find_package: built and ran"
if ! command -v pkg-config > /dev/null; then
  echo "pkg-config is not installed: that half is SKIPPED"
  exit 0
fi
export PKG_CONFIG_PATH=$(dirname "$(find "$work/prefix" -name segcal.pc)")
[ "$(pkg-config --modversion segcal)" = 0.1.0 ]
read -r -a flags <<< "$(pkg-config --cflags --libs segcal)"
cc -std=c99 "$consumer/consumer.c" "${flags[@]}" -o "$work/consumer"
"$work/consumer"
echo "pkg-config: built and ran"
