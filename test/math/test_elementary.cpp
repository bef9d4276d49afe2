// Errors of the elementary functions in units in the last place (ulp), against libm in a wider type.
#include <cmath>
#include <limits>

#include "../support/cases.h"
#include "../support/random.h"
#include "math/elementary.h"

using namespace SEGCAL_NS;
using test::Id;

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

// float is judged in double, double in long double (more than 53 bits on x86-64 and aarch64): the reference's own error
// is below a thousandth of an ulp.
template <class S>
using Wide = std::conditional_t<std::is_same<S, float>::value, double, long double>;

/// One ulp of S at x.
template <class S>
Wide<S> ulp(Wide<S> x) {
  const S a = std::fabs(static_cast<S>(x));
  return Wide<S>(std::nextafter(a, std::numeric_limits<S>::infinity())) - Wide<S>(a);
}

// The stated accuracy (math/elementary.h). A quotient of two such results, or of two such arguments, has one ulp more.
constexpr double kUlps = 2, kQuotientUlps = 3;

struct Worst {
  double ulps = 0, at = 0;
};

/// Largest error of `function` over random points; `smallest` is where errors turn from relative to absolute.
template <class S, class F, class Reference>
Worst worst_error(F function, Reference reference, double low, double high, double smallest) {
  test::Random random(11);
  Worst worst;
  for (int i = 0; i < 40000; ++i) {
    const S x = static_cast<S>(random.uniform(low, high));
    const Wide<S> expected = reference(Wide<S>(x));
    const Wide<S> unit = ulp<S>(std::max<Wide<S>>(std::fabs(expected), smallest));
    const double error = static_cast<double>(std::fabs(Wide<S>(function(x)) - expected) / unit);
    if (!(error <= worst.ulps)) worst = {error, static_cast<double>(x)};
  }
  return worst;
}

template <class S, class F, class Reference>
void check_range(const char* name, F function, Reference reference, double low, double high, double smallest = 0,
                 double limit = kUlps) {
  const Id id = Id().add("function", name).type<S>().add("low", low).add("high", high);
  if (!test::selected(id.text())) return;
  const Worst worst = worst_error<S>(function, reference, low, high, smallest);
  if (std::getenv("SEGCAL_VERBOSE")) std::printf("%s: %.3f ulp at %.9g\n", id.text().c_str(), worst.ulps, worst.at);
  test::check_between(id.add("x", worst.at), "ulps", 0, worst.ulps, limit);
}

template <class S>
void check_trigonometric() {
  const auto sin_ref = [](Wide<S> x) { return std::sin(x); };
  const auto cos_ref = [](Wide<S> x) { return std::cos(x); };
  const auto tan_ref = [](Wide<S> x) { return std::tan(x); };
  check_range<S>("sine", sine<S>, sin_ref, -0.8, 0.8);
  check_range<S>("sine", sine<S>, sin_ref, -1e-4, 1e-4);
  check_range<S>("cosine", cosine<S>, cos_ref, -0.8, 0.8);
  // Beyond the first zero the reduction is exact to a few 1e-9 (float), so values below 1e-2 are judged absolutely.
  for (double range : {3.2, 100.0, 1e4}) {
    check_range<S>("sine", sine<S>, sin_ref, -range, range, 1e-2);
    check_range<S>("cosine", cosine<S>, cos_ref, -range, range, 1e-2);
  }
  check_range<S>("tangent", tangent<S>, tan_ref, -1.3, 1.3, 0, kQuotientUlps);
}

template <class S>
void check_inverse() {
  const auto atan_ref = [](Wide<S> x) { return std::atan(x); };
  for (double range : {1e-3, 0.2, 1.0, 10.0, 1e6})
    check_range<S>("arc_tangent", arc_tangent<S>, atan_ref, -range, range);
  const auto log_ref = [](Wide<S> x) { return std::log(x); };
  check_range<S>("logarithm", logarithm<S>, log_ref, 0.7, 1.45);
  check_range<S>("logarithm", logarithm<S>, log_ref, 0.999, 1.001);
  check_range<S>("logarithm", logarithm<S>, log_ref, 1e-6, 1e6);
  check_range<S>("logarithm", logarithm<S>, log_ref, 1e-30, 1e-29);
  check_range<S>(
      "square_root", square_root<S>, [](Wide<S> x) { return std::sqrt(x); }, 0, 1e6);
}

template <class S>
void check_quadrants() {
  const Id id = Id().add("function", "arc_tangent2").type<S>();
  test::Random random(12);
  for (int i = 0; i < 20000; ++i) {
    const S y = static_cast<S>(random.normal()), x = static_cast<S>(random.normal());
    const Wide<S> expected = std::atan2(Wide<S>(y), Wide<S>(x));
    const double error = static_cast<double>(std::fabs(Wide<S>(arc_tangent2(y, x)) - expected) / ulp<S>(expected));
    test::check_between(id.add("i", i), "ulps", 0, error, kQuotientUlps);
  }
}

template <class S>
void check_special_points() {
  const Id id = Id().add("function", "special").type<S>();
  const auto same = [&](const char* what, S expected, S actual) { test::check_near(id, what, expected, actual, 0); };
  same("sin 0", 0, sine(S(0)));
  same("cos 0", 1, cosine(S(0)));
  same("tan 0", 0, tangent(S(0)));
  same("atan 0", 0, arc_tangent(S(0)));
  same("log 1", 0, logarithm(S(1)));
  same("sqrt 0", 0, square_root(S(0)));
  same("atan2(0, 0)", 0, arc_tangent2(S(0), S(0)));
  same("atan2(0, -1)", pi<S>, arc_tangent2(S(0), S(-1)));
  same("atan2(1, 0)", pi<S> / 2, arc_tangent2(S(1), S(0)));
  same("atan2(-1, 0)", -pi<S> / 2, arc_tangent2(S(-1), S(0)));
  same("sin of the smallest number", std::numeric_limits<S>::min(), sine(std::numeric_limits<S>::min()));
  // Odd and even to the last bit, which gradients by differences rely on.
  same("sin is odd", -sine(S(1.25)), sine(S(-1.25)));
  same("cos is even", cosine(S(1.25)), cosine(S(-1.25)));
  same("atan is odd", -arc_tangent(S(1.25)), arc_tangent(S(-1.25)));
  test::check_true(id, "finite",
                   is_finite(S(3)) && !is_finite(std::numeric_limits<S>::quiet_NaN()) &&
                       !is_finite(std::numeric_limits<S>::infinity()));
}

void test_trigonometric_functions() {
  check_trigonometric<float>();
  check_trigonometric<double>();
}

void test_inverse_functions() {
  check_inverse<float>();
  check_inverse<double>();
}

void test_arc_tangent_in_all_quadrants() {
  check_quadrants<float>();
  check_quadrants<double>();
}

void test_special_points() {
  check_special_points<float>();
  check_special_points<double>();
}

}  // namespace

int main(int argc, char** argv) {
  test::select_cases(argc, argv);
  UNITY_BEGIN();
  RUN_TEST(test_trigonometric_functions);
  RUN_TEST(test_inverse_functions);
  RUN_TEST(test_arc_tangent_in_all_quadrants);
  RUN_TEST(test_special_points);
  return UNITY_END();
}
