#!/bin/bash
# The recorded session, run by this program on this machine, must give the hash that a target gave.
#
# usage: same_hash.sh PROGRAM MEASURED.json
set -euo pipefail
program=${1:?usage: same_hash.sh PROGRAM MEASURED.json}
measured=${2:?usage: same_hash.sh PROGRAM MEASURED.json}
here=$("$program" 2>&1 | awk '$1 == "result_hash" { print $2 }')
there=$(python3 -c 'import json, sys; print(json.load(open(sys.argv[1]))["result_hash"])' "$measured")
echo "here $here, there $there"
[ -n "$here" ] && [ "$here" = "$there" ]
