/* Stand-in: a suite without set-up. A false assertion ends the program. */
#ifndef ZEPHYR_ZTEST_H
#define ZEPHYR_ZTEST_H
#include <stdbool.h>
#include <stddef.h>
#include <zephyr/sys/printk.h>

void stub_add_test(const char* suite, const char* name, void (*function)(void));
void stub_assert(bool holds, const char* condition, const char* file, int line);

#define TC_PRINT(...) printk(__VA_ARGS__)
#define ZTEST_SUITE(suite, predicate, setup, before, after, teardown) \
  static const void* const stub_suite_##suite[] = {predicate, setup, before, after, teardown, &stub_suite_##suite}
#define ZTEST(suite, name)                                         \
  static void name(void);                                          \
  __attribute__((constructor)) static void stub_add_##name(void) { \
    (void)stub_suite_##suite, stub_add_test(#suite, #name, name);  \
  }                                                                \
  static void name(void)
#define zassert_true(condition, ...) stub_assert(condition, #condition, __FILE__, __LINE__)
#define zassert_equal(a, b, ...) stub_assert((a) == (b), #a " == " #b, __FILE__, __LINE__)
#define zassert_not_equal(a, b, ...) stub_assert((a) != (b), #a " != " #b, __FILE__, __LINE__)
#endif
