// Re-integration of raw samples: the integral itself, and its covariance against Monte Carlo.
#include "../support/cases.h"
#include "../support/cast.h"
#include "../support/path.h"
#include "sensors/effect_catalogue.h"

using namespace SEGCAL_NS;
using test::Id;
using test::Path;

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

const Vec3<double> kGravity(0, 0, -9.80665);

Path make_path() {
  Path path;
  path.move[0] = {0.4, 3.1, 0.3};
  path.move[1] = {0.5, 2.3, 1.1};
  path.move[2] = {0.3, 4.2, 2.0};
  path.turn[0] = {0.5, 2.7, 0.9};
  path.turn[1] = {0.4, 3.3, 0.1};
  path.turn[2] = {0.7, 1.9, 1.7};
  return path;
}

ImuCalibration<double> device() {
  ImuCalibration<double> imu;
  imu.gyro_scale << 1.02, 0.97, 1.01;
  imu.gyro_misalignment << 0.01, -0.02, 0.015;
  imu.accel_scale << 0.96, 1.03, 1.02;
  imu.accel_misalignment << -0.02, 0.01, 0.03;
  imu.R_AI = so3_exp<double>(Vec3<double>(0.02, 0.03, -0.01));
  return imu;
}

InertialReading<double> measure(const Path& path, const ImuCalibration<double>& imu, const State<double>& b, double t) {
  return test::measure(path, imu, b.b_a, b.b_g, t);
}

State<double> biases() {
  State<double> x;
  x.b_a << 0.1, -0.2, 0.05;
  x.b_g << 0.02, -0.01, 0.03;
  return x;
}

/// Residual of the true states against the integral over [t0, t0 + steps dt].
template <class S>
Vec<double, 15> path_residual(double t0, double duration, int steps) {
  const Path path = make_path();
  const ImuCalibration<double> imu = device();
  const State<double> b = biases();
  ImuIntegrator<S> integrator(test::cast<S>(imu), b.b_a.cast<S>(), b.b_g.cast<S>(), ImuNoise<S>());
  const double dt = duration / steps;
  integrator.start(test::cast<S>(measure(path, imu, b, t0)));
  for (int i = 1; i <= steps; ++i) integrator.step(test::cast<S>(measure(path, imu, b, t0 + i * dt)), S(dt));
  State<S> x0 = test::cast<S>(path.state(t0)), x1 = test::cast<S>(path.state(t0 + duration));
  return link_residual<S>(integrator.result(), x0, x1, kGravity.cast<S>()).template cast<double>();
}

void test_integral_follows_the_path() {
  // Trapezoidal errors: dt^2 / 12 times the second derivative of rate (15 rad/s^3) and acceleration (100 m/s^4) per
  // second, at 200 Hz 3e-5 rad and 2e-4 m/s over a second, and they partly cancel.
  const Vec<double, 15> r = path_residual<double>(0.4, 1.0, 200);
  const Id id = Id().add("check", "path");
  test::check_near(id, "rotation", 0, r.head<3>().norm(), 6e-5);
  test::check_near(id, "velocity", 0, r.segment<3>(3).norm(), 6e-4);
  test::check_near(id, "position", 0, r.segment<3>(6).norm(), 6e-4);
}

/// A constant reading with a large effect on it, for a tenth of a second. Each pass leaves 2 k x of the effect, after
/// four (2 k x)^4 k x^2: 1.7e-5 rad/s of 3 rad/s and 1.3e-4 m/s^2 of 10 m/s^2.
void test_large_terms_are_taken_off() {
  const double dt = 0.005, rate = 3, force = 10, k_w = 0.017, k_f = 6e-3;
  EffectTerms<double> terms;
  terms.add(effect_term(5, 2), k_w);  // gyro_nonlinearity.z
  terms.add(effect_term(6, 0), k_f);  // accel_nonlinearity.x
  ImuIntegrator<double> integrator(ImuCalibration<double>(), Vec3<double>::Zero(), Vec3<double>::Zero(),
                                   ImuNoise<double>(), &terms);
  const InertialReading<double> reading{{0, 0, rate + k_w * rate * rate}, {force + k_f * force * force, 0, 0}};
  integrator.start(reading);
  for (int i = 0; i < 20; ++i) integrator.step(reading, dt);
  const ImuIntegral<double> integral = integrator.result();
  const Id id = Id().add("check", "large terms");
  test::check_near(id, "rotation", rate * 0.1, so3_log<double>(integral.dR).z(), 0.1 * 2e-5);
  // In a circle: |dv| = f t sin(w t / 2) / (w t / 2).
  test::check_near(id, "velocity", force * 0.1 * std::sin(0.15) / 0.15, integral.dv.norm(), 0.1 * 1.6e-4);
}

void test_integral_is_of_second_order() {
  // Halving the step must divide the error by four.
  for (int steps : {100, 200, 400}) {
    const double coarse = path_residual<double>(0.4, 1.0, steps).norm(),
                 fine = path_residual<double>(0.4, 1.0, 2 * steps).norm();
    test::check_between(Id().add("check", "order").add("steps", steps), "ratio of errors", 3.6, coarse / fine, 4.4);
  }
}

void test_integral_in_float() {
  // 200 sums of numbers up to 10 in float: their rounding wanders to 1e-5 at most.
  const Vec<double, 15> error = path_residual<float>(0.4, 1.0, 200) - path_residual<double>(0.4, 1.0, 200);
  test::check_near(Id().add("check", "float"), "difference", 0, error.norm(), 2e-5);
}

/// Samples of the path as a container keeps them, not rounded; ticks of a microsecond.
struct PathSamples {
  int count, period_us;
  Path path;
  int size() const { return count; }
  std::int32_t time(int i) const { return i * period_us; }
  InertialReading<double> reading(int i) const { return measure(path, device(), biases(), time(i) * 1e-6); }
};

/// Residual of the true states over [0.2 s, 1.2 s] by way of a container, which takes the trapezoids' error out first.
Vec<double, 15> stored_residual(const Path& path, int period_us) {
  const PathSamples samples = {1400000 / period_us, period_us, path};
  const State<double> b = biases();
  ImuIntegrator<double> integrator(device(), b.b_a, b.b_g, ImuNoise<double>());
  integrate_samples<double>(samples, 200000, 1200000, 1e-6, &integrator);
  return link_residual<double>(integrator.result(), path.state(0.2), path.state(1.2), kGravity);
}

void test_stored_samples_are_corrected() {
  // Against the raw samples at 200 Hz. What is left comes from the two ends, which fall between samples' corrections.
  const Vec<double, 15> raw = path_residual<double>(0.2, 1.0, 200), r = stored_residual(make_path(), 5000);
  const Id id = Id().add("check", "corrected");
  test::check_near(id, "rotation", 0, r.head<3>().norm(), 0.02 * raw.head<3>().norm());
  test::check_near(id, "velocity", 0, r.segment<3>(3).norm(), 0.02 * raw.segment<3>(3).norm());
  test::check_near(id, "position", 0, r.segment<3>(6).norm(), 0.02 * raw.segment<3>(6).norm());
}

void test_correction_is_of_fourth_order() {
  // About all axes at once, with forces: coning and sculling are part of it.
  for (int period_us : {5000, 10000}) {
    const double fine = stored_residual(make_path(), period_us).norm(),
                 coarse = stored_residual(make_path(), 2 * period_us).norm();
    test::check_between(Id().add("check", "fourth_order").add("period", period_us), "ratio of errors", 14,
                        coarse / fine, 18);
  }
}

/// Noise with a bias walk strong enough for its part of the covariance to be as large as that of the white noise.
ImuNoise<double> strong_walk() {
  ImuNoise<double> noise;
  noise.gyro = 1e-3;
  noise.accel = 1e-2;
  noise.gyro_walk = 8e-3;
  noise.accel_walk = 8e-2;
  return noise;
}

constexpr int kSteps = 60;
constexpr double kDt = 0.005;

/// Integrates the path once with noise; the residual of the true states and biases is what the covariance describes.
Vec<double, 15> noisy_residual(const ImuNoise<double>& noise, test::Random* random, ImuIntegral<double>* integral) {
  const Path path = make_path();
  const ImuCalibration<double> imu = device();
  State<double> b = biases();
  ImuIntegrator<double> integrator(imu, b.b_a, b.b_g, noise);
  const double white = 1 / std::sqrt(kDt), walk = std::sqrt(kDt);
  State<double> x0 = path.state(0), x1 = path.state(kSteps * kDt);
  x0.b_a = b.b_a;
  x0.b_g = b.b_g;
  for (int i = 0; i <= kSteps; ++i) {
    InertialReading<double> reading = measure(path, imu, b, i * kDt);
    reading.gyro += random->vector(noise.gyro * white);
    reading.accel += random->vector(noise.accel * white);
    if (i == 0) {
      integrator.start(reading);
    } else {
      integrator.step(reading, kDt);
    }
    if (i == kSteps) break;
    b.b_a += random->vector(noise.accel_walk * walk);
    b.b_g += random->vector(noise.gyro_walk * walk);
  }
  x1.b_a = b.b_a;
  x1.b_g = b.b_g;
  *integral = integrator.result();
  return link_residual<double>(*integral, x0, x1, kGravity);
}

constexpr int kRuns = 6000;

/// Sample covariance over kRuns runs, normalised by the predicted sigmas, minus the predicted correlation.
Mat<double, 15, 15> covariance_error(const ImuNoise<double>& noise, Mat<double, 15, 15>* correlation) {
  test::Random random(31), quiet(31);
  ImuIntegral<double> integral;
  ImuNoise<double> none;
  none.gyro = none.accel = none.gyro_walk = none.accel_walk = 0;
  const Vec<double, 15> offset = noisy_residual(none, &quiet, &integral);
  Mat<double, 15, 15> sum = Mat<double, 15, 15>::Zero();
  for (int i = 0; i < kRuns; ++i) {
    const Vec<double, 15> r = noisy_residual(noise, &random, &integral) - offset;
    sum += r * r.transpose() / kRuns;
  }
  // The predicted covariance, taken on the path itself.
  ImuIntegrator<double> mean(device(), biases().b_a, biases().b_g, noise);
  const Path path = make_path();
  mean.start(measure(path, device(), biases(), 0));
  for (int i = 1; i <= kSteps; ++i) mean.step(measure(path, device(), biases(), i * kDt), kDt);
  Mat<double, 15, 15> Q;
  link_covariance(mean.result(), noise, &Q);
  const Vec<double, 15> scale = Q.diagonal().cwiseSqrt().cwiseInverse();
  *correlation = scale.asDiagonal() * Q * scale.asDiagonal();
  return scale.asDiagonal() * (sum - Q) * scale.asDiagonal();
}

void check_covariance(const char* name, const ImuNoise<double>& noise) {
  Mat<double, 15, 15> correlation;
  const Mat<double, 15, 15> error = covariance_error(noise, &correlation);
  // An entry of a sample covariance of n normalised samples has sigma sqrt((1 + c^2) /
  // n): 1.3 to 1.8 % for n = 6000. Five of those, and 2 % for the sums' end points (a
  // trapezoid of 60 steps has 59.5 steps' worth of white noise; the walk moves in steps).
  for (int i = 0; i < 15; ++i) {
    for (int j = 0; j <= i; ++j) {
      const double tolerance = 5 * std::sqrt((1 + correlation(i, j) * correlation(i, j)) / kRuns) + 0.02;
      test::check_near(Id().add("noise", name).add("row", i).add("column", j), "covariance", 0, error(i, j), tolerance);
    }
  }
}

void test_covariance_of_white_noise() {
  ImuNoise<double> noise = strong_walk();
  // Walks of no effect, but not zero: the covariance of the biases is normalised too.
  noise.gyro_walk = 1e-6;
  noise.accel_walk = 1e-6;
  check_covariance("white", noise);
}

void test_covariance_with_bias_walk() { check_covariance("walk", strong_walk()); }

void test_integration_between_samples() {
  // Ends that fall between two samples are interpolated: two parts give the same as the whole.
  const PathSamples samples = {100, 5000, make_path()};
  const auto integral = [&](int from, int to) {
    ImuIntegrator<double> integrator(device(), biases().b_a, biases().b_g, ImuNoise<double>());
    integrate_samples<double>(samples, from, to, 1e-6, &integrator);
    return integrator.result();
  };
  const ImuIntegral<double> whole = integral(1200, 401300), a = integral(1200, 203700), b = integral(203700, 401300);
  test::check_near(Id().add("check", "split"), "duration", whole.dt, a.dt + b.dt, 1e-12);
  // The split adds one point to a piecewise linear signal; the rotation's trapezoid differs in third order only.
  test::check_near(Id().add("check", "split"), "rotation", 0, (a.dR * b.dR - whole.dR).norm(), 1e-6);
}

}  // namespace

int main(int argc, char** argv) {
  test::select_cases(argc, argv);
  UNITY_BEGIN();
  RUN_TEST(test_integral_follows_the_path);
  RUN_TEST(test_large_terms_are_taken_off);
  RUN_TEST(test_integral_is_of_second_order);
  RUN_TEST(test_integral_in_float);
  RUN_TEST(test_stored_samples_are_corrected);
  RUN_TEST(test_correction_is_of_fourth_order);
  RUN_TEST(test_covariance_of_white_noise);
  RUN_TEST(test_covariance_with_bias_walk);
  RUN_TEST(test_integration_between_samples);
  return UNITY_END();
}
