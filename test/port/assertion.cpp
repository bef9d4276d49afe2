// With SEGCAL_ASSERT=1 an assumption of the core that does not hold reaches the port; without it there is no check.
// Exit code 0: as the build says.
#include <cstdio>
#include <cstdlib>

#include "math/types.h"
#include "segcal/port.h"

#if defined(SEGCAL_ASSERT) && SEGCAL_ASSERT
constexpr bool kChecked = true;
#else
constexpr bool kChecked = false;
#endif

extern "C" void segcal_port_assert_failed(const char* condition, const char* file, int line) {
  std::printf("%s:%d: %s\n", file, line, condition);
  std::exit(kChecked ? 0 : 1);
}

int main() {
  Eigen::Matrix<float, 3, 1> v(1, 2, 3);
  volatile int beyond = kChecked ? 4 : 3;
  v.head(beyond).setZero();  // Eigen's check of the length, which becomes the port's
  return kChecked ? 2 : 0;
}
