// The inertial link: residual and all 45 columns (both states,
// the inertial part of theta), two ways, in float and double.
#include <Eigen/LU>

#include "../support/cast.h"
#include "../support/random.h"
#include "jacobian_check.h"
#include "jet_imu.h"

using namespace SEGCAL_NS;
using test::Id;

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

using Columns = Eigen::Matrix<double, jet::kLinkColumns, 1>;
const Vec3<double> kGravity(0, 0, -9.80665);

/// A link with everything that its residual depends on.
struct Link {
  const char* name;
  jet::Samples samples;
  ImuCalibration<double> imu;
  State<double> x0, x1;
};

ImuCalibration<double> disturbed_imu() {
  ImuCalibration<double> imu;
  imu.gyro_scale << 1.01, 0.99, 1.02;
  imu.gyro_misalignment << 0.004, -0.006, 0.003;
  imu.accel_scale << 0.98, 1.02, 1.01;
  imu.accel_misalignment << -0.01, 0.012, 0.008;
  imu.R_AI = so3_exp<double>(Vec3<double>(0.01, -0.02, 0.015));
  return imu;
}

State<double> disturbed_state() {
  State<double> x;
  x.R_GI = so3_exp<double>(Vec3<double>(0.7, -1.3, 0.4));
  x.p_GI << 0.4, -0.7, 1.1;
  x.v_GI << 0.6, 0.3, -0.4;
  x.b_a << 0.05, -0.08, 0.03;
  x.b_g << 0.01, -0.004, 0.006;
  return x;
}

/// Samples of a hand-held motion: rates of 2 rad/s and 5 m/s^2 beside gravity.
jet::Samples moving_samples(int count, double scale) {
  jet::Samples samples;
  for (int i = 0; i < count; ++i) {
    const double t = i * samples.dt;
    const Vec3<double> rate(std::sin(9 * t + 1), std::cos(7 * t), std::sin(5 * t + 2));
    const Vec3<double> force(std::cos(8 * t), std::sin(11 * t + 1), std::cos(6 * t + 2));
    samples.reading.push_back({scale * 2 * rate, scale * 5 * force - kGravity});
  }
  return samples;
}

/// Puts x1 where the integral says, moved by `offset` (so that the residual is -offset up to its frame).
void complete(Link* link, const Columns& offset) {
  Columns zero = Columns::Zero();
  link->x1 = link->x0;
  for (int i = 0; i < 3; ++i) {
    const Eigen::Matrix<double, 15, 1> r =
        jet::link_residual<double>(link->samples, link->imu, link->x0, link->x1, kGravity, zero.data());
    link->x1.R_GI = renormalised<double>(link->x1.R_GI * so3_exp<double>(Vec3<double>(-r.head<3>())));
    link->x1.v_GI -= link->x0.R_GI * r.segment<3>(3);
    link->x1.p_GI -= link->x0.R_GI * r.segment<3>(6);
  }
  link->x1.add(offset.data());
}

std::vector<Link> links() {
  const Columns none = Columns::Zero();
  Columns small = none, tiny = none;
  small.head<15>() << 0.02, -0.03, 0.01, 0.05, -0.04, 0.02, 0.1, 0.05, -0.1, 0.01, 0.02, -0.01, 1e-3, -2e-3, 1e-3;
  tiny.head<3>() << 1e-8, -1e-8, 2e-8;
  std::vector<Link> list;
  list.push_back({"ordinary", moving_samples(41, 1), disturbed_imu(), disturbed_state(), {}});
  complete(&list.back(), small);
  list.push_back({"exact", moving_samples(41, 1), disturbed_imu(), disturbed_state(), {}});
  complete(&list.back(), none);
  list.push_back({"one_second", moving_samples(201, 1), disturbed_imu(), disturbed_state(), {}});
  complete(&list.back(), small);
  list.push_back({"one_step", moving_samples(2, 1), disturbed_imu(), disturbed_state(), {}});
  complete(&list.back(), small);
  // At rest with nominal calibration: every rotation in the chain is the identity.
  list.push_back({"identity", moving_samples(21, 0), ImuCalibration<double>(), State<double>(), {}});
  complete(&list.back(), none);
  list.push_back({"tiny_rotation", moving_samples(21, 1e-7), ImuCalibration<double>(), State<double>(), {}});
  complete(&list.back(), tiny);
  return list;
}

/// What type S holds of the link.
template <class S>
Link rounded(const Link& a) {
  Link b = a;
  for (auto& reading : b.samples.reading) reading = test::cast<double>(test::cast<S>(reading));
  b.imu = test::cast<double>(test::cast<S>(a.imu));
  b.x0 = test::cast<double>(test::cast<S>(a.x0));
  b.x1 = test::cast<double>(test::cast<S>(a.x1));
  return b;
}

template <class S>
ImuIntegral<S> integrate(const Link& link, const ImuCalibration<S>& imu, const State<S>& x0) {
  ImuIntegrator<S> integrator(imu, x0.b_a, x0.b_g, ImuNoise<S>());
  integrator.start(test::cast<S>(link.samples.reading[0]));
  for (std::size_t i = 1; i < link.samples.reading.size(); ++i) {
    integrator.step(test::cast<S>(link.samples.reading[i]), S(link.samples.dt));
  }
  return integrator.result();
}

template <class S>
Eigen::VectorXd residual_after(const Link& link, const Eigen::VectorXd& step) {
  Calibration<S> theta;
  theta.imu = test::cast<S>(link.imu);
  S theta_step[kMaxTheta] = {}, step0[kStateColumns], step1[kStateColumns];
  for (int i = 0; i < kStateColumns; ++i) {
    step0[i] = S(step(i));
    step1[i] = S(step(kStateColumns + i));
    theta_step[theta.imu_column() + i] = S(step(2 * kStateColumns + i));
  }
  add_step(&theta, theta_step);
  State<S> x0 = test::cast<S>(link.x0), x1 = test::cast<S>(link.x1);
  x0.add(step0);
  x1.add(step1);
  return link_residual<S>(integrate<S>(link, theta.imu, x0), x0, x1, kGravity.cast<S>()).template cast<double>();
}

template <class S>
Eigen::MatrixXd analytic(const Link& link) {
  const State<S> x0 = test::cast<S>(link.x0), x1 = test::cast<S>(link.x1);
  ImuRows<S> rows;
  link_rows<S>(integrate<S>(link, test::cast<S>(link.imu), x0), x0, x1, x0, x1, kGravity.cast<S>(), &rows);
  return rows.J.template cast<double>();
}

Eigen::MatrixXd automatic(const Link& link, Eigen::VectorXd* residual) {
  using T = ceres::Jet<double, jet::kLinkColumns>;
  T step[jet::kLinkColumns];
  for (int i = 0; i < jet::kLinkColumns; ++i) step[i] = T(0.0, i);
  const Eigen::Matrix<T, 15, 1> r = jet::link_residual<T>(link.samples, link.imu, link.x0, link.x1, kGravity, step);
  Eigen::MatrixXd J(15, jet::kLinkColumns);
  residual->resize(15);
  for (int i = 0; i < 15; ++i) {
    (*residual)(i) = r[i].a;
    J.row(i) = r[i].v.transpose();
  }
  return J;
}

/// Rows have different units: each block of three is checked alone. Its zero is judged by the link's duration, which is
/// what velocities and positions move by.
template <class S>
void check_rows(const Id& id, const Link& link, const Eigen::MatrixXd& J, const Eigen::MatrixXd& expected) {
  const double duration = link.samples.dt * double(link.samples.reading.size() - 1);
  for (int block = 0; block < 5; ++block) {
    const double floor = block == 2 ? duration * duration : duration;
    test::check_automatic<S>(id.add("block", block), J.middleRows(3 * block, 3), expected.middleRows(3 * block, 3),
                             floor);
  }
}

template <class S>
void check_link(const Link& original) {
  const Link link = rounded<S>(original);
  const Id id = Id().add("link", link.name).template type<S>();
  Eigen::VectorXd expected;
  const Eigen::MatrixXd J_auto = automatic(link, &expected), J = analytic<S>(link);
  // Sums of numbers up to 10 (gravity times a second) in S.
  const double value_tolerance = 100 * double(std::numeric_limits<S>::epsilon());
  test::check_near(id, "residual", 0, (residual_after<S>(link, Columns::Zero()) - expected).cwiseAbs().maxCoeff(),
                   value_tolerance);
  check_rows<S>(id.add("by", "jet"), link, J, J_auto);
  // All variables are of order one (rad, m, m/s, scale); biases act through seconds, so they may be stepped as far.
  const auto f = [&](const Eigen::VectorXd& step) { return residual_after<S>(link, step); };
  test::check_differences<S>(id.add("by", "differences"), J, Columns::Ones(), f, kGravity.norm());
}

void test_link_in_double() {
  for (const Link& link : links()) check_link<double>(link);
}

void test_link_in_float() {
  for (const Link& link : links()) check_link<float>(link);
}

/// Whitening is a change of basis: W' W must be the inverse covariance, for residual and Jacobian alike.
void test_whitening() {
  const Link link = links()[0];
  const ImuNoise<double> noise;
  const ImuIntegral<double> I = integrate<double>(link, link.imu, link.x0);
  ImuRows<double> rows;
  link_rows<double>(I, link.x0, link.x1, link.x0, link.x1, kGravity, &rows);
  const ImuRows<double> plain = rows;
  TEST_ASSERT_TRUE(whiten(I, noise, &rows));
  Mat<double, 15, 15> covariance;
  link_covariance(I, noise, &covariance);
  const Mat<double, 15, 15> information = covariance.inverse();
  const double expected = plain.r.dot(information * plain.r);
  test::check_near(Id().add("check", "whitening"), "squared length", expected, rows.r.squaredNorm(), 1e-8 * expected);
  const Eigen::MatrixXd gram = plain.J.transpose() * information * plain.J, whitened = rows.J.transpose() * rows.J;
  test::check_near(Id().add("check", "whitening"), "J'J", 0, (gram - whitened).norm() / gram.norm(), 1e-8);
  Vec<double, 15> alone;
  TEST_ASSERT_TRUE(whiten_residual(I, noise, plain.r, &alone));
  test::check_near(Id().add("check", "whitening"), "residual alone", 0, (alone - rows.r).norm(), 1e-12 * rows.r.norm());
}

/// The link's cost with one of the six scales moved.
double cost_at(Link link, int scale, double step) {
  (scale < 3 ? link.imu.gyro_scale(scale) : link.imu.accel_scale(scale - 3)) += step;
  const ImuIntegral<double> I = integrate<double>(link, link.imu, link.x0);
  Vec<double, 15> w;
  TEST_ASSERT_TRUE(whiten_residual(I, ImuNoise<double>(), link_residual(I, link.x0, link.x1, kGravity), &w));
  return w.squaredNorm();
}

/// r' P^-1 r changes with a scale through P too; the column without the readings' noise says by how much.
void test_rows_are_the_slope_of_the_cost() {
  Columns offset = Columns::Zero();
  // Some sigmas: white noise is 7e-5 rad, 9e-4 m/s and 1e-4 m after 0.2 s.
  offset.head<9>() << 2e-4, -1e-4, 1.5e-4, 3e-4, -2e-4, 1e-4, 3e-3, 2e-3, -2.5e-3;
  Link link = links()[0];
  complete(&link, offset);
  const ImuIntegral<double> I = integrate<double>(link, link.imu, link.x0);
  ImuRows<double> rows;
  link_rows<double>(I, link.x0, link.x1, link.x0, link.x1, kGravity, &rows);
  ImuRows<double> plain = rows;
  take_noise_off_scales(I, &rows);
  TEST_ASSERT_TRUE(whiten(I, ImuNoise<double>(), &rows));
  TEST_ASSERT_TRUE(whiten(I, ImuNoise<double>(), &plain));
  double by_noise = 0, left = 0;
  for (int scale = 0; scale < 6; ++scale) {
    const int column = 2 * kStateColumns + (scale < 3 ? scale : scale + 3);
    const double h = 1e-5, slope = (cost_at(link, scale, h) - cost_at(link, scale, -h)) / (2 * h);
    by_noise += std::pow(slope - 2 * plain.J.col(column).dot(plain.r), 2);
    left += std::pow(slope - 2 * rows.J.col(column).dot(rows.r), 2);
    std::printf("scale %d: slope %.3f, 2 J'r %.3f, without noise %.3f\n", scale, slope,
                2 * plain.J.col(column).dot(plain.r), 2 * rows.J.col(column).dot(rows.r));
  }
  // The axes turn within the link, and the gyroscope's noise has a part in the velocity's, with the force.
  test::check_between(Id().add("check", "slope"), "of P's part, left", 0, std::sqrt(left / by_noise), 0.25);
}

}  // namespace

int main(int argc, char** argv) {
  test::select_cases(argc, argv);
  UNITY_BEGIN();
  RUN_TEST(test_link_in_double);
  RUN_TEST(test_link_in_float);
  RUN_TEST(test_whitening);
  RUN_TEST(test_rows_are_the_slope_of_the_cost);
  return UNITY_END();
}
