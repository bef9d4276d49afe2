#!/bin/sh
# The gate itself: one object for each kind of forbidden symbol must turn it red, and a harmless one must pass.
#
# usage: test_symbol_gate.sh CXX WORK_FOLDER
set -u
cxx=$1
work=$2
gate=$(dirname "$0")/symbol_gate.sh
mkdir -p "$work" || exit 2
failures=0

# expect CODE NAME SOURCE: compiles the source and compares the gate's exit code.
expect() {
  printf '%s\n' "$3" > "$work/$2.cpp"
  "$cxx" -O1 -fno-builtin -c "$work/$2.cpp" -o "$work/$2.o" || { echo "$2: does not compile"; failures=1; return; }
  "$gate" "$work/$2.o" 2> "$work/$2.txt"
  code=$?
  [ "$code" -eq "$1" ] && return
  echo "$2: exit code $code, expected $1"
  cat "$work/$2.txt"
  failures=1
}

expect 0 clean 'extern "C" void* memset(void*, int, unsigned long); float f(float* x) { memset(x, 0, 4); return *x * 2; }'
expect 1 malloc '#include <stdlib.h>
void* f(unsigned n) { return malloc(n); }'
expect 1 free '#include <stdlib.h>
void f(void* p) { free(p); }'
expect 1 operator_new 'int* f() { return new int[4]; }'
expect 1 operator_delete 'void f(int* p) { delete p; }'
expect 1 throwing 'void f(int x) { if (x) throw x; }'
expect 1 guard 'int g(); int f() { static int x = g(); return x; }'
expect 1 sinf '#include <math.h>
float f(float x) { return sinf(x); }'
expect 1 atan2 '#include <math.h>
double f(double x) { return atan2(x, 2.0); }'
expect 1 sqrt '#include <math.h>
double f(double x) { return sqrt(x); }'
expect 1 printf '#include <stdio.h>
void f() { printf("x"); }'
expect 1 assert '#include <assert.h>
void f(int x) { assert(x); }'
expect 1 abort '#include <stdlib.h>
void f() { abort(); }'

"$gate" "$work/absent.o" 2> /dev/null
[ $? -eq 2 ] || { echo "absent: a missing file must be an error"; failures=1; }
[ "$failures" -eq 0 ] && echo "symbol gate: all kinds are refused"
exit $failures
