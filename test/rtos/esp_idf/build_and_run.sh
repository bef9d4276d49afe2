#!/bin/bash
# usage: build_and_run.sh CMAKE ROOT COMPOTE EIGEN_FOLDER WORK_FOLDER OPTIMISATION
# Packs the component, first into a folder, then with Espressif's compote as for the component registry; builds the example that is in the archive
# with the stand-in for ESP-IDF, from nothing, and runs it. No file of the repository may be used.
set -euo pipefail
[ $# -eq 6 ] || { echo "usage: $0 CMAKE ROOT COMPOTE EIGEN_FOLDER WORK_FOLDER OPTIMISATION" >&2; exit 2; }
cmake=$1 root=$2 compote=$3 work=$5
IDF_PATH=$(cd "$(dirname "$0")" && pwd)
export IDF_PATH
rm -rf "$work"
"$cmake" -DOUT="$work/packed/segcal" -P "$root/port/esp_idf/pack.cmake"
"$compote" component pack --name segcal --project-dir "$work/packed/segcal" --dest-dir "$work/archive"
mkdir -p "$work/taken/segcal"
tar xzf "$work"/archive/segcal_*.tgz -C "$work/taken/segcal"
rm -r "$work/packed"
for file in LICENSE README.md idf_component.yml examples/calibrate/README.md; do
  [ -s "$work/taken/segcal/$file" ] || { echo "the archive lacks $file"; exit 1; }
done
# The core as one unit: less work in all.
"$cmake" -G Ninja -S "$work/taken/segcal/examples/calibrate" -B "$work/build" -DSTUB_EIGEN="$4" -DSTUB_OPTIMISATION="$6" \
         -DCMAKE_UNITY_BUILD=ON -DCMAKE_UNITY_BUILD_BATCH_SIZE=0
"$cmake" --build "$work/build"
used=$(cat "$work/build/build.ninja"; ninja -C "$work/build" -t deps)
if grep -E "$root/(lib|port|examples)/" <<< "$used"; then
  echo "that is of the repository, not of the component"
  exit 1
fi
"$work/build/calibrate.elf"
