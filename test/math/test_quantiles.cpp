// Quantiles for tests against values from numerical integration of the densities.
#include <unity.h>

#include "../support/cases.h"
#include "math/quantiles.h"

using test::Id;

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

template <class S>
void check_normal() {
  const double value[][2] = {{0.4, 0.253347}, {0.05, 1.644854}, {1e-3, 3.090232}, {1e-6, 4.753424}};
  for (const auto& [p, z] : value) {
    const Id id = Id().add("type", test::type_name<S>()).add("p", p);
    test::check_near(id, "z", z, double(segcal_mobile::normal_upper_quantile(S(p))), 5e-4);  // of the formula
  }
}

template <class S>
void check_f() {
  struct Row {
    int m, n;
    double p, x;
  };
  for (const Row& r : {Row{20, 20, 0.01, 2.9377}, Row{10, 30, 1e-3, 4.2388}, Row{26, 26, 1.4e-4, 4.4857},
                       Row{26, 150, 1.4e-4, 2.6269}, Row{12, 400, 0.05, 1.7764}, Row{29, 60, 1e-5, 3.6809}}) {
    const Id id = Id().add("type", test::type_name<S>()).add("m", r.m).add("n", r.n).add("p", r.p);
    test::check_near(id, "ratio to the exact one", 1, double(segcal_mobile::f_upper_quantile(r.m, r.n, S(r.p))) / r.x,
                     0.02);
  }
  TEST_ASSERT_TRUE(segcal_mobile::f_upper_quantile(26, 1, S(1e-4)) == S(0));  // too little for any limit
}

void test_normal() {
  check_normal<float>();
  check_normal<double>();
}
void test_f() {
  check_f<float>();
  check_f<double>();
}

}  // namespace

int main(int argc, char** argv) {
  test::select_cases(argc, argv);
  UNITY_BEGIN();
  RUN_TEST(test_normal);
  RUN_TEST(test_f);
  return UNITY_END();
}
