// Rotations: round trips, Jacobians against central differences, identity, tiny angles, angles near pi.
#include <Eigen/Geometry>
#include <limits>

#include "../support/cases.h"
#include "../support/random.h"
#include "math/so3.h"

using namespace SEGCAL_NS;
using test::Id;

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

/// Machine epsilon as a double.
template <class S>
double epsilon() {
  return std::numeric_limits<S>::epsilon();
}

/// Angles that every property is tried at: identity, below and above each series' threshold, and up to pi.
constexpr double kAngles[] = {0, 1e-12, 1e-8, 1e-4, 1e-3, 2e-3, 0.0999, 0.1001, 0.4999, 0.5001, 1, 2, 3, 3.14, 3.14159};

template <class S>
Id angle_id(const char* property, double angle) {
  return Id().add("property", property).type<S>().add("angle", angle);
}

/// Reference rotation in double from Eigen's quaternion.
Mat3<double> reference_exp(const Vec3<double>& phi) {
  const double angle = phi.norm();
  if (angle == 0) return Mat3<double>::Identity();
  return Eigen::AngleAxisd(angle, phi / angle).toRotationMatrix();
}

template <class S>
void check_exp() {
  test::Random random(1);
  for (double angle : kAngles) {
    const Vec3<S> phi = (angle * random.direction()).cast<S>();
    const Mat3<double> error = so3_exp(phi).template cast<double>() - reference_exp(phi.template cast<double>());
    // Sums of three products of numbers below one, each rounded: a few epsilon.
    test::check_near(angle_id<S>("exp", angle), "largest entry", 0, error.cwiseAbs().maxCoeff(), 8 * epsilon<S>());
  }
}

template <class S>
void check_round_trip() {
  test::Random random(2);
  for (double angle : kAngles) {
    const Vec3<S> phi = (angle * random.direction()).cast<S>();
    const Vec3<double> back = so3_log(so3_exp(phi)).template cast<double>();
    // The matrix holds the vector to a few epsilon; near pi the quaternion's w = cos(angle / 2) is small but its
    // absolute error is the same, so nothing is lost.
    const double error = (back - phi.template cast<double>()).norm();
    test::check_near(angle_id<S>("round_trip", angle), "log(exp)", 0, error, 8 * epsilon<S>() * (1 + angle));
  }
}

template <class S>
void check_half_turns() {
  // Exactly pi: Log may answer either sign, and Exp of it must be the same matrix.
  for (int axis = 0; axis < 3; ++axis) {
    Mat3<S> R = -Mat3<S>::Identity();
    R(axis, axis) = 1;
    const Vec3<S> phi = so3_log(R);
    const Id id = Id().add("property", "half_turn").type<S>().add("axis", axis);
    test::check_near(id, "angle", pi<double>, phi.template cast<double>().norm(), 4 * epsilon<S>());
    test::check_near(id, "exp(log)", 0, double((so3_exp(phi) - R).cwiseAbs().maxCoeff()), 8 * epsilon<S>());
  }
}

/// Column of the right Jacobian by central differences: Log(Exp(phi)' Exp(phi + h e)) / h.
template <class S>
Vec3<double> numeric_column(const Vec3<S>& phi, int column, S h) {
  const Vec3<S> step = h * Vec3<S>::Unit(column);
  const Mat3<S> Rt = so3_exp(phi).transpose();
  const Vec3<S> plus = so3_log<S>(Rt * so3_exp<S>(phi + step)), minus = so3_log<S>(Rt * so3_exp<S>(phi - step));
  return (plus - minus).template cast<double>() / (2.0 * h);
}

template <class S>
void check_jacobian() {
  // Step: the cube root of epsilon balances rounding (epsilon / h) and truncation (h^2); tolerance: 20 times that.
  const double h = std::cbrt(epsilon<S>()), tolerance = 20 * h * h;
  test::Random random(3);
  for (double angle : kAngles) {
    const Vec3<S> phi = (angle * random.direction()).cast<S>();
    const Mat3<S> J = so3_right_jacobian(phi), inverse = so3_right_jacobian_inverse(phi);
    for (int c = 0; c < 3; ++c) {
      const double error = (J.col(c).template cast<double>() - numeric_column<S>(phi, c, S(h))).norm();
      test::check_near(angle_id<S>("jacobian", angle).add("column", c), "differences", 0, error, tolerance);
    }
    const Mat3<double> product = (J * inverse).template cast<double>();
    test::check_near(angle_id<S>("inverse", angle), "J J^-1 - I", 0, (product - Mat3<double>::Identity()).norm(),
                     40 * epsilon<S>());
  }
}

template <class S>
void check_series_is_continuous() {
  // Just below the threshold the series answers, just above the closed form; the functions themselves hardly move.
  const double threshold = std::is_same<S, float>::value ? 0.25 : 1e-2;
  const S below = static_cast<S>(threshold * (1 - 4 * epsilon<S>())),
          above = static_cast<S>(threshold * (1 + 4 * epsilon<S>()));
  const RotationSeries<S> s = rotation_series(below), f = rotation_series(above);
  const Id id = Id().add("property", "threshold").type<S>();
  // 1 - cos t and t - sin t cancel: their rounding is epsilon / t^2 and epsilon / t^2 relative to what is left.
  test::check_near(id, "a", s.a, f.a, 8 * epsilon<S>());
  test::check_near(id, "b", s.b, f.b, 4 * epsilon<S>() / threshold);
  test::check_near(id, "c", s.c, f.c, 4 * epsilon<S>() / threshold);
}

template <class S>
void check_tiny_rotation() {
  // 1e-8 rad is far below float's epsilon and must come through Exp and Log unharmed all the same.
  const Vec3<S> phi(S(1e-8), S(-2e-8), S(3e-8));
  const Vec3<double> back = so3_log(so3_exp(phi)).template cast<double>();
  // Off-diagonal entries carry it with full relative precision; b phi phi' (1e-15) is all that is added to them.
  test::check_near(Id().add("property", "tiny").type<S>(), "relative", 0,
                   (back - phi.template cast<double>()).norm() / phi.template cast<double>().norm(), 1e-6);
}

template <class S>
void check_quaternion() {
  test::Random random(4);
  for (double angle : kAngles) {
    const Mat3<S> R = so3_exp<S>((angle * random.direction()).template cast<S>());
    const Vec<S, 4> q = quaternion_from_matrix(R);
    const Id id = angle_id<S>("quaternion", angle);
    test::check_near(id, "unit length", 1, q.template cast<double>().norm(), 8 * epsilon<S>());
    test::check_near(id, "round trip", 0, double((matrix_from_quaternion(q) - R).cwiseAbs().maxCoeff()),
                     8 * epsilon<S>());
    // Any length is accepted.
    const Mat3<S> scaled = matrix_from_quaternion<S>(S(3) * q);
    test::check_near(id, "scaled", 0, double((scaled - R).cwiseAbs().maxCoeff()), 8 * epsilon<S>());
    const Mat3<S> drifted = R * S(1.001);
    const Mat3<double> N = renormalised(drifted).template cast<double>();
    test::check_near(id, "orthogonal", 0, (N.transpose() * N - Mat3<double>::Identity()).norm(), 16 * epsilon<S>());
  }
}

template <class S>
void check_all() {
  check_exp<S>();
  check_round_trip<S>();
  check_half_turns<S>();
  check_jacobian<S>();
  check_series_is_continuous<S>();
  check_tiny_rotation<S>();
  check_quaternion<S>();
}

void test_rotations_in_float() { check_all<float>(); }
void test_rotations_in_double() { check_all<double>(); }

}  // namespace

int main(int argc, char** argv) {
  test::select_cases(argc, argv);
  UNITY_BEGIN();
  RUN_TEST(test_rotations_in_float);
  RUN_TEST(test_rotations_in_double);
  return UNITY_END();
}
