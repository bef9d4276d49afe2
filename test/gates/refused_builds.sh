#!/bin/bash
# refused_builds.sh COMPILER SOURCE_DIR EIGEN_DIR: options and capacities with which the core would give wrong answers in silence do
# not compile, and say why; their neighbours do.
set -uo pipefail
compiler=$1 source=$2 eigen=$3 failed=0

compile() { # options...
  echo '#include "api/handle.h"' | "$compiler" -x c++ -std=c++17 -O1 -fsyntax-only -I"$source/lib/include" -I"$source/lib/src" \
    -I"$source/port/include" -isystem "$eigen" -DSEGCAL_PROFILE=1 "$@" - 2>&1
}

refused() { # words options...
  local words=$1 said
  shift
  if said=$(compile "$@"); then
    echo "compiles with $*, and must not"
    failed=1
  elif ! grep -q -- "error: #error.*$words" <<< "$said"; then
    echo "with $* it does not say \"$words\":"
    head -n 3 <<< "$said"
    failed=1
  fi
}

taken() { # options...
  local said
  said=$(compile "$@") || { echo "does not compile with $*:"; head -n 3 <<< "$said"; failed=1; }
}

taken
refused "-ffast-math" -ffast-math
refused "-ffast-math" -Ofast
refused "-ffinite-math-only" -ffinite-math-only
taken -DSEGCAL_START_DELAY_MS=1500
refused "SEGCAL_START_DELAY_MS" -DSEGCAL_START_DELAY_MS=1501
taken -DSEGCAL_MAX_EPOCHS=2
refused "SEGCAL_MAX_EPOCHS" -DSEGCAL_MAX_EPOCHS=1
refused "SEGCAL_PROFILE" -USEGCAL_PROFILE -DSEGCAL_PROFILE=4
exit $failed
