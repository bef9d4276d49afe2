// camera_temperature counts from the mean warmth of the segments where the review asks for it.
#include <string>

#include "review/mean_warmth.h"
#include "sensors/effect_terms.h"
#include "unity.h"

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

using namespace host::diagnosis;

constexpr int kTheta = 15;  // gyro.sx, then two cameras' r_CI, fx fy cx cy
constexpr double kFx = 400, kFy = 410;

std::vector<host::CoreParameter> parameters() {
  std::vector<host::CoreParameter> out(1);
  out[0].name = "gyro.sx";
  for (const char* camera : {"cam0.", "cam1."}) {
    for (const char* name : {"r_CI.x", "r_CI.y", "r_CI.z", "fx", "fy", "cx", "cy"}) {
      out.emplace_back();
      out.back().name = std::string(camera) + name;
      out.back().value = name[1] == 'x' ? kFx : kFy;
    }
  }
  return out;
}

/// rotation about y, focal length, centre's y; and one that is of the IMU
std::vector<TermInfo> terms() {
  std::vector<TermInfo> out(4);
  const int values[] = {1, 3, 5};
  for (int i = 0; i < 3; ++i) out[i].term = {static_cast<int>(SEGCAL_NS::TermKind::camera_warmth), values[i], 0, 0};
  out[3].term = {static_cast<int>(SEGCAL_NS::TermKind::gyro_x), 1, 0, 0};
  return out;
}

/// Rows of a segment at this warmth: columns of the terms are warmth times what the cameras' are.
Rows rows_at(double warmth, unsigned seed) {
  std::srand(seed);
  Rows out{Eigen::MatrixXd::Zero(60, kTheta + 5), 40};
  out.R.leftCols(kTheta) = Eigen::MatrixXd::Random(60, kTheta);
  const auto of_camera = [&](int c, int i) { return out.R.col(1 + 7 * c + i); };
  for (int c = 0; c < 2; ++c) {
    out.R.col(kTheta) += warmth * of_camera(c, 1);
    out.R.col(kTheta + 1) += warmth * (kFx * of_camera(c, 3) + kFy * of_camera(c, 4));
    out.R.col(kTheta + 2) += warmth * kFy * of_camera(c, 6);
  }
  out.R.rightCols(2) = Eigen::MatrixXd::Random(60, 2);
  out.R = triangle_of(out.R);
  return out;
}

Problem problem_at(double first, double second) {
  Problem out;
  out.n_theta = kTheta;
  const Rows a = rows_at(first, 1), b = rows_at(second, 2);
  out.all = sum_of({&a, &b});
  out.train = a;
  out.held_out = b;
  out.pieces = {{a, 0, 4, false}, {b, 4, 8, true}};
  return out;
}

/// 15 degC above all the time: nothing is left of the effect, whoever is asked; and of the others nothing is touched.
void test_a_constant_temperature_moves_nothing() {
  const Problem before = problem_at(15, 15);
  Problem p = before;
  host::review::count_from_mean_warmth(parameters(), terms(), &p);
  const auto check = [](const Rows& was, const Rows& is) {
    for (int i = 0; i < 3; ++i) TEST_ASSERT_DOUBLE_WITHIN(1e-8, 0, is.R.col(kTheta + i).norm());  // of 1e4
    TEST_ASSERT_TRUE(was.R.leftCols(kTheta) == is.R.leftCols(kTheta));
    TEST_ASSERT_TRUE(was.R.rightCols(2) == is.R.rightCols(2));
  };
  check(before.all, p.all);
  check(before.train, p.train);
  check(before.held_out, p.held_out);
  check(before.pieces[1].rows, p.pieces[1].rows);
}

/// Halves at 5 and 25 degC above: each is left with the 10 by which it is off the mean, within what their weights
/// differ.
void test_the_mean_is_taken_off() {
  const Problem before = problem_at(5, 25);
  Problem p = before;
  host::review::count_from_mean_warmth(parameters(), terms(), &p);
  for (int i = 0; i < 3; ++i) {
    TEST_ASSERT_DOUBLE_WITHIN(1.5, 10.0 / 5, p.train.R.col(kTheta + i).norm() / before.train.R.col(kTheta + i).norm());
    TEST_ASSERT_DOUBLE_WITHIN(0.15, 10.0 / 25,
                              p.held_out.R.col(kTheta + i).norm() / before.held_out.R.col(kTheta + i).norm());
  }
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_a_constant_temperature_moves_nothing);
  RUN_TEST(test_the_mean_is_taken_off);
  return UNITY_END();
}
