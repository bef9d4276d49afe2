#!/bin/bash
# usage: pkg_config.sh EXAMPLE_FOLDER PREFIX PROGRAM VERSION
# Builds the example with what is installed in PREFIX, as PROGRAM, and runs it.
set -euo pipefail
[ $# -eq 4 ] || { echo "usage: $0 EXAMPLE_FOLDER PREFIX PROGRAM VERSION" >&2; exit 2; }
PKG_CONFIG_PATH=$(dirname "$(find "$2" -name segcal.pc)")
export PKG_CONFIG_PATH
[ "$(pkg-config --modversion segcal)" = "$4" ]
rm -f "$3"
make -C "$1" OUT="$3"
"$3"
