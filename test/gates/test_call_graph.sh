#!/bin/bash
# The call graph's gate itself: recursion, a frame of variable size, an indirect call and a function without a known frame must
# turn it red, and so must a limit that is passed; a plain chain of calls must pass with the sum of its frames.
#
# usage: test_call_graph.sh WORK_FOLDER [TOOL_PREFIX]
set -u
work=${1:?usage: test_call_graph.sh WORK_FOLDER [TOOL_PREFIX]}
tools=${2:-}
gate=$(dirname "$0")/call_graph.py
failures=0

# expect CODE NAME WORDS SOURCE [OPTION...]: compiles the source; the gate must end with CODE and say WORDS.
expect() {
  local code=$1 name=$2 words=$3 source=$4 folder=$work/call_graph_$2 answer
  shift 4
  rm -rf "$folder" && mkdir -p "$folder"
  printf '%s\n' "$source" > "$folder/$name.c"
  "${tools}gcc" -O1 -fcallgraph-info=su,da -c "$folder/$name.c" -o "$folder/$name.o" || { failures=1; return; }
  "$gate" --graphs "$folder" "$@" > "$folder/answer.txt" 2>&1
  answer=$?
  if [ "$answer" -ne "$code" ] || ! grep -q -e "$words" "$folder/answer.txt"; then
    echo "$name: exit code $answer, expected $code and the words '$words'"
    cat "$folder/answer.txt"
    failures=1
  fi
}

use='void use(void *);'
expect 0 plain 'worst stack: 1[0-9][0-9] bytes' "__attribute__((noinline)) static int f(int x) { volatile char a[64]; a[x] = 1; return a[0]; }
int segcal_f(int x) { volatile char a[32]; a[x] = 1; return f(x) + a[0]; }"
expect 1 recursion 'recursion: segcal_f -> g -> segcal_f' "int segcal_f(int); __attribute__((noinline)) int g(int x) { return segcal_f(x - 1) + 1; }
int segcal_f(int x) { return x ? g(x) * 3 : 0; }"
expect 1 dynamic 'frame of variable size: segcal_f' "$use int segcal_f(int n) { char a[n]; use(a); return a[0]; }" --assume use=0
expect 1 indirect 'indirect call from segcal_f' 'int segcal_f(int (*g)(int)) { return g(1) + 1; }'
expect 0 callback 'worst stack' 'int segcal_f(int (*g)(int)) { return g(1) + 1; }' --callbacks segcal_f
expect 1 unknown 'no frame is known of use' "$use int segcal_f(void) { char a[8]; use(a); return a[0]; }"
expect 1 limit 'over the limit of 100 bytes' "$use int segcal_f(void) { char a[128]; use(a); return a[0]; }" --assume use=0 --limit 100
# Assembly of a linked image: a function with two names, and one that runs on into it, as in libgcc.
if [ -n "$tools" ]; then
  assembly='__asm__(".syntax unified\n.thumb\n.thumb_func\n.global through\n.type through,%function\nthrough: push {r4, r5}\n"
        ".thumb_func\n.global shown\n.type shown,%function\nshown: push {r4, lr}\npop {r4, pc}\nnop\n"
        ".thumb_func\n.global another\n.type another,%function\nanother: push {r0-r7}\nbx lr\n.thumb_set alias, shown\n.global alias\n");'
  expect 0 alias 'worst stack: 16 bytes' "$assembly void alias(void); void segcal_f(void) { alias(); alias(); }" \
         --image "$work/call_graph_alias/alias.o" --objdump "${tools}objdump"
  expect 0 through 'worst stack: 24 bytes' "$assembly void through(void); void segcal_f(void) { through(); through(); }" \
         --image "$work/call_graph_through/through.o" --objdump "${tools}objdump"
fi
expect 2 nothing 'no call graph' 'int other(void) { return 1; }'

[ "$failures" -eq 0 ] && echo "call graph: all kinds are refused"
exit $failures
