#!/bin/bash
# Usage: readme_program.sh README PROGRAM
# The README's C program must be the file, to the last character. Prints the difference if it is not.
set -euo pipefail
readme=${1:?usage: readme_program.sh README PROGRAM}
program=${2:?usage: readme_program.sh README PROGRAM}
awk '/^```c$/ { inside = 1; next } /^```/ { inside = 0 } inside' "$readme" | diff "$program" -
