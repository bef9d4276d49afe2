/* Tests that run on the targets themselves, with Unity and without a C++ library. */
#ifndef SEGCAL_TARGET_TESTS_H
#define SEGCAL_TARGET_TESTS_H

#ifdef __cplusplus
extern "C" {
#endif

void test_port(void);
void test_api(void);
void test_math(void);

#ifdef __cplusplus
}
#endif
#endif
