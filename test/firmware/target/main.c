#include <unity.h>

#include "tests.h"

void setUp(void) {}
void tearDown(void) {}

int main(void) {
  UNITY_BEGIN();
  test_port();
  test_api();
  test_math();
  return UNITY_END();
}
