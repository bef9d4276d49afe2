/* QEMU plugin: counts the instructions that an image executes between segcal_mark_begin and the next segcal_mark_NAME
 * (see test/firmware/marks.h) and writes one line "NAME count" for each such call, in the order of the calls.
 *
 *   qemu-system-arm ... -plugin counter.so,out=COUNTS[,profile=PROFILE]
 *
 * Whole blocks of translated code are counted where they begin. A block is left early only by a fault, and an image
 * that faults counts for nothing, so the figures are exact, and the same in each run. profile=FILE: instructions per
 * function. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "qemu_plugin.h"

__attribute__((visibility("default"))) int qemu_plugin_version = 1;

enum { kMostSymbols = 4096 };
static const char mark_prefix[] = "segcal_mark_";
static FILE* out;
static const char* profile_path;
static uint64_t executed, begun;
static int inside;
static struct {
  const char* name;
  uint64_t executed;
} symbols[kMostSymbols];
static int n_symbols;

static void on_mark(unsigned cpu, void* name) {
  (void)cpu;
  if (strcmp(name, "begin") == 0) {
    begun = executed;
    inside = 1;
  } else if (inside) {
    fprintf(out, "%s %llu\n", (const char*)name, (unsigned long long)(executed - begun));
    inside = 0;
  }
}

static uint64_t* counter_of(const char* name) {
  int i = 0;
  while (i < n_symbols && strcmp(symbols[i].name, name) != 0) ++i;
  if (i == kMostSymbols) i = 0;
  if (i == n_symbols) symbols[n_symbols++].name = strdup(name);
  return &symbols[i].executed;
}

static void on_translation(qemu_plugin_id_t id, struct qemu_plugin_tb* block) {
  (void)id;
  const char* name = qemu_plugin_insn_symbol(qemu_plugin_tb_get_insn(block, 0));
  const uint64_t n = qemu_plugin_tb_n_insns(block);
  if (name && strncmp(name, mark_prefix, sizeof mark_prefix - 1) == 0) {
    qemu_plugin_register_vcpu_tb_exec_cb(block, on_mark, QEMU_PLUGIN_CB_NO_REGS, strdup(name + sizeof mark_prefix - 1));
  }
  qemu_plugin_register_vcpu_tb_exec_inline(block, QEMU_PLUGIN_INLINE_ADD_U64, &executed, n);
  if (profile_path)
    qemu_plugin_register_vcpu_tb_exec_inline(block, QEMU_PLUGIN_INLINE_ADD_U64, counter_of(name ? name : "?"), n);
}

static int by_count(const void* a, const void* b) {
  const uint64_t x = *(const uint64_t*)((const char*)a + sizeof(char*)),
                 y = *(const uint64_t*)((const char*)b + sizeof(char*));
  return x < y ? 1 : x > y ? -1 : 0;
}

static void on_exit_of_image(qemu_plugin_id_t id, void* data) {
  (void)id, (void)data;
  fprintf(out, "all %llu\n", (unsigned long long)executed);
  fclose(out);
  if (!profile_path) return;
  FILE* profile = fopen(profile_path, "w");
  if (!profile) return;
  qsort(symbols, (size_t)n_symbols, sizeof symbols[0], by_count);
  for (int i = 0; i < n_symbols; ++i)
    fprintf(profile, "%llu %s\n", (unsigned long long)symbols[i].executed, symbols[i].name);
  fclose(profile);
}

__attribute__((visibility("default"))) int qemu_plugin_install(qemu_plugin_id_t id, const qemu_plugin_info_t* info,
                                                               int argc, char** argv) {
  const char* path = NULL;
  (void)info;
  for (int i = 0; i < argc; ++i) {
    if (strncmp(argv[i], "out=", 4) == 0) path = strdup(argv[i] + 4);
    if (strncmp(argv[i], "profile=", 8) == 0) profile_path = strdup(argv[i] + 8);
  }
  out = path ? fopen(path, "w") : NULL;
  if (!out) {
    fprintf(stderr, "instruction_counter: give out=FILE, a file that can be written\n");
    return 1;
  }
  qemu_plugin_register_vcpu_tb_trans_cb(id, on_translation);
  qemu_plugin_register_atexit_cb(id, on_exit_of_image, NULL);
  return 0;
}
