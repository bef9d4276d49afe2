#!/bin/bash
# Of the objects of a library, a shared library made from them exports the C API and nothing else. Prints how many functions these are.
#
# usage: exports.sh LIBRARY PREFIX
set -euo pipefail
[ $# -eq 2 ] || { echo "usage: $0 LIBRARY PREFIX" >&2; exit 2; }
symbols=$(readelf -sW "$1" | awk '$5 != "LOCAL" && $6 == "DEFAULT" && $7 ~ /^[0-9A-Z]+$/ && $7 != "UND" {print $8}' | sort -u)
others=$(grep -v "^$2" <<< "$symbols" || true)
if [ -n "$others" ]; then
  echo "$1: $(wc -l <<< "$others") symbols beside the C API would be exported, as" >&2
  head -3 <<< "$others" | c++filt >&2
  exit 1
fi
count=$(grep -c "^$2" <<< "$symbols")
echo "$1: $count functions"
[ "$count" -ge 40 ]
