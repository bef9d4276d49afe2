#!/bin/sh
# Every C function of a library that was built with SEGCAL_RENAME has the prefix: one that symbol_names.h forgets would be called in
# another profile's library, with another layout of the device. Arguments: the library, the prefix.
set -eu
plain=$(nm --defined-only -g "$1" | awk -v prefix="$2" '$2 == "T" && $3 ~ /^segcal_/ && index($3, prefix) != 1 { print $3 }')
[ -n "$(nm --defined-only -g "$1" | grep " T $2")" ] || { echo "$1: no function has the prefix $2"; exit 1; }
[ -z "$plain" ] || { echo "not in lib/include/segcal/symbol_names.h:" $plain; exit 1; }
