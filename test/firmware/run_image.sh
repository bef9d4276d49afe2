#!/bin/bash
# Runs a program of one of the targets, in QEMU where it is not the host's, and passes its output and exit code on.
# With COUNTS, the instruction counter COUNTER (a QEMU plugin) writes what each marked call took; PROFILE: per function.
#
# usage: run_image.sh TARGET PROGRAM [COUNTER COUNTS [PROFILE]]
set -euo pipefail
[ $# -eq 2 ] || [ $# -ge 4 ] || { echo "usage: $0 TARGET PROGRAM [COUNTER COUNTS [PROFILE]]" >&2; exit 2; }
target=$1
program=$2
plugin=()
[ $# -ge 4 ] && plugin=(-plugin "$3,out=$4${5:+,profile=$5}")

board() {
  exec qemu-system-arm -M "$1" -display none -monitor none -serial none -chardev stdio,id=log \
    -semihosting-config enable=on,target=native,chardev=log "${plugin[@]}" -kernel "$program"
}

case $target in
  cortex-m7) board mps2-an500 ;;
  cortex-m55) board mps3-an547 ;;
  cortex-m33) board mps2-an505 ;;
  aarch64) exec qemu-aarch64 "${plugin[@]}" "$program" ;;
  x86-64)
    if [ "${#plugin[@]}" -eq 0 ]; then exec "$program"; fi
    exec qemu-x86_64 "${plugin[@]}" "$program" ;;
  *)
    echo "$0: unknown target $target: cortex-m7, cortex-m55, cortex-m33, aarch64 or x86-64" >&2
    exit 2 ;;
esac
