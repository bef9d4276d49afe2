#!/bin/bash
# usage: two_profiles.sh BOTH SMALL LARGE
# What a program with two builds prints is what the programs with one print. Shows the difference if it is not.
set -euo pipefail
[ $# -eq 3 ] || { echo "usage: $0 BOTH SMALL LARGE" >&2; exit 2; }
expected=$("$2" && "$3")
echo "$expected"
diff <(echo "$expected") <("$1")
