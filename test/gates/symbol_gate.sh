#!/bin/sh
# Refuses an object file or static library that refers to anything the core must not have: heap, exceptions and their
# tables, guards of statics, mathematics of libm, output, or the end of the process.
#
# usage: symbol_gate.sh LIBRARY_OR_OBJECT...      exit code 0: clean, 1: refused (each symbol is named), 2: bad usage
set -u
[ $# -ge 1 ] || { echo "usage: $0 LIBRARY_OR_OBJECT..." >&2; exit 2; }
nm=${NM:-nm}

heap='malloc|free|calloc|realloc|aligned_alloc|posix_memalign|memalign|alloca|_sbrk|sbrk'
# operator new and delete (_Znwm, _Znam, _ZdlPv, _ZdaPvm ...), not the placement form, which is inline.
operators='_Zn[wa][a-z].*|_Zd[la]Pv.*'
exceptions='__cxa_.*|_Unwind_.*|__gxx_personality.*|__gcc_personality.*|_ZSt[0-9]+__throw.*|_ZTI.*|_ZTV.*__cxxabiv.*|__dynamic_cast|__aeabi_atexit|atexit'
functions='sin|cos|tan|asin|acos|atan|atan2|sinh|cosh|tanh|asinh|acosh|atanh|sincos|exp|exp2|expm1|exp10|log|log2|log10|log1p|pow|sqrt|cbrt|hypot|fmod|remainder|remquo|fma|modf|frexp|ldexp|scalbn|erf|erfc|tgamma|lgamma|floor|ceil|round|lround|llround|trunc|rint|nearbyint|lrint|fabs|fmin|fmax|isnan'
mathematics="(${functions})[fl]?|__(${functions})[fl]?_finite"
output='printf|fprintf|sprintf|snprintf|vprintf|vsnprintf|puts|putchar|fputs|fwrite|__printf_chk|__fprintf_chk|__sprintf_chk|__snprintf_chk|_ZSt4cout|_ZSt4cerr|_ZNSo.*|_ZNSt8ios_base.*'
end='abort|exit|_exit|quick_exit|_ZSt9terminatev|__assert_fail|__assert|__assert_func|__stack_chk_fail|longjmp|setjmp|_setjmp'
random='rand|srand|random|time|clock|getenv'

list=$("$nm" --undefined-only --format=posix "$@") || { echo "$0: nm cannot read $*" >&2; exit 2; }
[ -n "$("$nm" --format=posix "$@" 2>/dev/null)" ] || { echo "$0: no symbols in $*" >&2; exit 2; }
bad=$(printf '%s\n' "$list" | awk '{ sub(/@.*/, "", $1); print $1 }' |
  grep -Ex "${heap}|${operators}|${exceptions}|${mathematics}|${output}|${end}|${random}" | sort -u)
[ -z "$bad" ] && exit 0
echo "$0: forbidden symbols in $*:" >&2
printf '%s\n' "$bad" | sed 's/^/  /' >&2
exit 1
