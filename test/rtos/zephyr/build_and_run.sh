#!/bin/bash
# usage: build_and_run.sh CMAKE MODULE PYTHON APPLICATION SCENARIO BUILD_FOLDER OPTIMISATION
# Builds an application with the stand-in for Zephyr, from nothing, and runs it.
set -euo pipefail
[ $# -eq 7 ] || { echo "usage: $0 CMAKE MODULE PYTHON APPLICATION SCENARIO BUILD_FOLDER OPTIMISATION" >&2; exit 2; }
rm -rf "$6"
ZEPHYR_BASE=$(cd "$(dirname "$0")" && pwd)
export ZEPHYR_BASE
# The core as one unit: less work in all.
"$1" -G Ninja -S "$4" -B "$6" -DZEPHYR_EXTRA_MODULES="$2" -DSTUB_PYTHON="$3" -DSTUB_SCENARIO="$5" -DSTUB_OPTIMISATION="$7" \
     -DCMAKE_UNITY_BUILD=ON -DCMAKE_UNITY_BUILD_BATCH_SIZE=0
"$1" --build "$6"
"$6/zephyr/zephyr_exe"
