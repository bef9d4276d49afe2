#!/bin/bash
# The linker's gate (port/cortex_m/sections.ld) itself: an image with a heap, an exception, libm or a static constructor must not
# link, the same image without them must.
#
# usage: test_link_gate.sh WORK_FOLDER
set -u
work=${1:?usage: test_link_gate.sh WORK_FOLDER}
root=$(cd "$(dirname "$0")/../.." && pwd)
failures=0
mkdir -p "$work"

# expect WORDS NAME SOURCE: links an image of the source; WORDS: what the linker must say, or "links".
expect() {
  local words=$1 name=$2 said=$work/link_$2.txt code
  printf '%s\n' "$3" > "$work/link_$name.cpp"
  arm-none-eabi-g++ -mcpu=cortex-m7 -mthumb -mfloat-abi=hard -mfpu=fpv5-d16 -O1 -fno-builtin -fno-unwind-tables \
    -nostdlib -nostartfiles -L"$root/port/cortex_m" -T"$root/port/mps2_an500/memory.ld" \
    -Wl,--defsym=Reset_Handler=main,--no-warn-rwx-segments,--no-warn-execstack "$work/link_$name.cpp" \
    -Wl,--start-group -lm -lc -lgcc -Wl,--end-group -o "$work/link_$name.elf" > "$said" 2>&1
  code=$?
  if [ "$words" = links ]; then
    [ "$code" -eq 0 ] && return
  elif [ "$code" -ne 0 ] && grep -q -e "$words" "$said"; then
    return
  fi
  echo "$name: exit code $code, expected: $words"
  cat "$said"
  failures=1
}

expect links clean 'int main() { return 0; }'
expect '_sbrk' malloc '#include <stdlib.h>
int main() { return malloc(4) != 0; }'
expect 'holds a heap' own_heap 'extern "C" void* malloc(unsigned) { return 0; } int main() { return malloc(4) != 0; }'
expect 'operator new' operator_new 'int main() { return *new int; }'
expect '__cxa_throw' throwing 'int main() { throw 1; }'
expect 'holds exceptions or guards' guard 'extern "C" int __cxa_guard_acquire(void*) { return 0; } int g(); int main() { return __cxa_guard_acquire(0); }'
expect 'holds libm' sinf '#include <math.h>
volatile float x = 1; int main() { return sinf(x) > 0; }'
expect 'static object has a constructor' constructor 'int f() { return 1; } volatile int x; struct A { A() { x = f(); } } a; int main() { return x; }'

[ "$failures" -eq 0 ] && echo "link gate: all kinds are refused"
exit $failures
