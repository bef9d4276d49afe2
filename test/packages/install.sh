#!/bin/bash
# usage: install.sh CMAKE BUILD_FOLDER PREFIX
# Installs into an empty folder.
set -euo pipefail
[ $# -eq 3 ] || { echo "usage: $0 CMAKE BUILD_FOLDER PREFIX" >&2; exit 2; }
rm -rf "$3"
"$1" --install "$2" --prefix "$3"
