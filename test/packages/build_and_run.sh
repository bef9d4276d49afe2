#!/bin/bash
# usage: build_and_run.sh CMAKE EXAMPLE_FOLDER BUILD_FOLDER PROGRAM [CMAKE_OPTION...]
# Builds an example as its reader would, from nothing, and runs it; PROGRAM `run`: the example's own target runs it.
set -euo pipefail
[ $# -ge 4 ] || { echo "usage: $0 CMAKE EXAMPLE_FOLDER BUILD_FOLDER PROGRAM [CMAKE_OPTION...]" >&2; exit 2; }
cmake=$1 example=$2 build=$3 program=$4
shift 4
rm -rf "$build"
"$cmake" -G Ninja -S "$example" -B "$build" "$@"
if [ "$program" = run ]; then
  "$cmake" --build "$build"
  "$cmake" --build "$build" --target run
else
  "$cmake" --build "$build"
  "$build/$program"
fi
