#!/bin/bash
# Usage: demo.sh SEGCAL FOLDER
# Simulates a 60 s headset session, calibrates from it and writes the report; then the same with the real recording
# euroc_mh01, where $SEGCAL_DATA or ../shared/data holds it. Exit code 1 if a calibration was not reached.
set -euo pipefail

segcal=${1:?usage: demo.sh SEGCAL FOLDER}
folder=${2:?usage: demo.sh SEGCAL FOLDER}
source_folder=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
data=${SEGCAL_DATA:-$source_folder/../shared/data}
answer=0

step() { printf '\n$ segcal %s\n' "$*"; "$segcal" "$@"; }

# replay_and_report RECORDING OUT [OPTION...]: replay prints the calibration. Its exit code 1 is an answer, worth a report;
# others stop here.
replay_and_report() {
  local recording=$1 out=$2 code=0
  step replay "$recording" "${@:3}" --out "$out" || code=$?
  [ "$code" -le 1 ] || exit "$code"
  [ "$code" -eq 0 ] || answer=1
  step report "$out"
  echo "report: $out/report.html"
}

rm -rf "$folder"
mkdir -p "$folder"
step simulate --out "$folder/rec" --scenario arvr --seconds 60 --seed 1
replay_and_report "$folder/rec" "$folder/out"

if [ -d "$data/euroc_mh01/mav0" ]; then
  start=$source_folder/fixtures/euroc_mh01_start.yaml
  step track "$data/euroc_mh01" --calib "$start" --out "$folder/euroc_mh01"
  replay_and_report "$folder/euroc_mh01" "$folder/euroc_mh01_out" --calib "$start"
else
  printf '\nNo real recording: set SEGCAL_DATA to a folder that holds euroc_mh01 to see one calibrated.\n'
fi
exit "$answer"
