#!/bin/bash
# usage: same_output.sh REFERENCE COMMAND...
# The last line that COMMAND prints must be all that the program REFERENCE prints. Where it fails, its output is shown.
set -euo pipefail
[ $# -ge 2 ] || { echo "usage: $0 REFERENCE COMMAND..." >&2; exit 2; }
expected=$("$1")
shift
if ! output=$("$@" 2>&1); then
  echo "$output"
  exit 1
fi
echo "here:    $expected"
echo "package: ${output##*$'\n'}"
[ "${output##*$'\n'}" = "$expected" ]
