// The gap of each sensor: on rows with a known truth, and from simulated recordings to the answer.
#include <Eigen/Cholesky>
#include <cmath>
#include <cstdio>
#include <string>

#include "../support/cases.h"
#include "../support/random.h"
#include "diagnose/diagnose.h"
#include "diagnose/evidence.h"
#include "diagnose/hypotheses.h"
#include "diagnose/sensor_gap.h"
#include "simulate/effect_names.h"
#include "simulate/simulate.h"

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

using namespace host::diagnosis;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using host::Diagnosis;

constexpr int kTheta = 5, kEffects = 2, kSegments = 16;
constexpr int kRows[kSensors] = {200, 40, 60};

/// Rows of three sensors without states, noise of factors `f`; effect 0 shows in sensor `seen_by` alone. `theta`: not
/// 0, and the device is that far from its data sheet, in sigmas of the prior, and only the last sensor sees it, in a
/// fold as well as the prior knows it.
struct SensorRecording {
  Problem problem;
  SensorPieces pieces;
  std::vector<Candidate> candidates{{"offset", {0, 1}, {1}, 0.4}, {"lag", {1, 1}, {1}, 0.4}};
};

SensorRecording recording_of(int seed, double value, int seen_by, const std::array<double, kSensors>& f,
                             double theta = 0) {
  test::Random random(seed);
  SensorRecording out;
  out.problem.n_theta = kTheta;
  out.problem.prior = {VectorXd::Zero(kTheta), VectorXd::Constant(kTheta, 1.0)};
  std::vector<const Rows*> all, half[2];
  for (int i = 0; i < kSegments; ++i) {
    std::vector<Rows> sensors;
    std::vector<const Rows*> pointers;
    for (int s = 0; s < kSensors; ++s) {
      MatrixXd rows = random.matrix(kRows[s], kTheta + kEffects + 1);
      if (s != seen_by) rows.col(kTheta).setZero();
      if (theta != 0) rows.leftCols(kTheta) *= s + 1 == kSensors ? 1 / std::sqrt(kSegments / 4.0 * kRows[s]) : 0;
      rows.rightCols(1) =
          f[s] * rows.rightCols(1) + value * rows.col(kTheta) + theta * rows.leftCols(kTheta).rowwise().sum();
      sensors.push_back({rows, static_cast<double>(kRows[s])});
    }
    for (const Rows& r : sensors) pointers.push_back(&r);
    out.problem.pieces.push_back({sum_of(pointers), 4.0 * i, 4.0 * i + 4, is_held_out(i)});
    for (int s = 0; s < kSensors; ++s) out.pieces.of[s].push_back({sensors[s], 4.0 * i, 4.0 * i + 4, false});
    out.pieces.shared.push_back(Eigen::Vector3d(kRows[0], kRows[1], kRows[2]).asDiagonal());
  }
  for (const Piece& p : out.problem.pieces) {
    all.push_back(&p.rows);
    half[p.held_out ? 1 : 0].push_back(&p.rows);
  }
  out.problem.all = sum_of(all);
  out.problem.train = sum_of(half[0]);
  out.problem.held_out = sum_of(half[1]);
  return out;
}

struct Measured {
  std::array<SensorGap, kSensors> of;
  double fall = 0;  ///< of the folds' chi2, from their own rows
};

Measured measured(const SensorRecording& r, const std::array<Floor, kSensors>& noise = {}) {
  const Selection s = select_effects(r.candidates, {}, [&r](const std::vector<int>&) { return r.problem; });
  const std::vector<Fold> folds = folds_of(s, sums_of_pieces(s.problem.pieces));
  Measured out{gap_by_sensor(s, folds, r.pieces, noise), 0};
  for (const Fold& fold : folds) {
    const Trained t = trained_on(fold.training, fold.candidates, fold.accepted);
    if (fold.missed || t.value.size() == 0) continue;
    Rows rows = with_groups(with_prior(fold.own.all, fold.own.prior), kTheta, t.groups);
    const Rows without = with_groups(with_prior(fold.own.all, fold.own.prior), kTheta, {});
    rows.R.col(kTheta) = rows.R.rightCols(1) - rows.R.middleCols(kTheta, t.value.size()) * t.value;
    rows.R = triangle_of(rows.R.leftCols(kTheta + 1));
    out.fall += solve(without).cost - solve(rows).cost;
  }
  return out;
}

/// Nothing there: means of many recordings are zero, and their spread is
/// the sigma that is told. Noise of other sizes, known, changes nothing.
void test_nothing_there_is_nothing_open() {
  const std::array<double, kSensors> f{1, 2, 0.5};
  VectorXd sum = VectorXd::Zero(kSensors), squares = VectorXd::Zero(kSensors);
  constexpr int kRuns = 200;
  for (int seed = 0; seed < kRuns; ++seed) {
    const Measured m = measured(recording_of(seed, 0, kSensors, f), {Floor{1, 0}, Floor{4, 0}, Floor{0.25, 0}});
    for (int s = 0; s < kSensors; ++s) {
      const double z = m.of[s].before / m.of[s].sigma;
      sum(s) += z / kRuns;
      squares(s) += z * z / kRuns;
    }
  }
  for (int s = 0; s < kSensors; ++s) {
    std::printf("sensor %d without effect: mean %.2f, mean square %.2f of sigma\n", s, sum(s), squares(s));
    TEST_ASSERT_DOUBLE_WITHIN(4 / std::sqrt(kRuns), 0, sum(s));
    TEST_ASSERT_DOUBLE_WITHIN(0.4, 1, squares(s));
  }
}

/// Squares of a sensor that are not what the segment's rows say: no gap of a sensor is told.
void test_sensors_that_do_not_add_up() {
  SensorRecording r = recording_of(1, 0, kSensors, {1, 1, 1});
  TEST_ASSERT_TRUE(measured(r).of[0].dof > 0);
  r.pieces.of[1][5].rows.R *= 1.8;  // of 300 rows 40: 0.3 of the squares too many
  for (const SensorGap& gap : measured(r).of) TEST_ASSERT_EQUAL_DOUBLE(0, gap.dof);
  r = recording_of(1, 0, kSensors, {1, 1, 1});
  r.pieces.of[1][5].rows.R(3, 2) = std::nan("");
  for (const SensorGap& gap : measured(r).of) TEST_ASSERT_EQUAL_DOUBLE(0, gap.dof);
}

/// A device three sigmas from its data sheet, whose last sensor tells as much about it as the prior does: a prior that
/// pulls would leave 3^2 / 4 of chi2 in each of the directions, one sigma of the gap in all.
void test_data_sheet_opens_nothing() {
  constexpr int kRuns = 60;
  double mean = 0;
  for (int seed = 0; seed < kRuns; ++seed) {
    const SensorGap gap = measured(recording_of(1000 + seed, 0, kSensors, {1, 1, 1}, 3)).of[kSensors - 1];
    mean += gap.before / gap.sigma / kRuns;
  }
  TEST_ASSERT_DOUBLE_WITHIN(4 / std::sqrt(kRuns), 0, mean);
}

/// An effect opens the gap of the sensor that sees it, the effect closes it, and falls add up to the whole's.
void test_the_sensor_that_sees_it() {
  for (int seen_by = 0; seen_by < kSensors; ++seen_by) {
    const Measured m = measured(recording_of(7 + seen_by, 0.5, seen_by, {1, 1, 1}));
    double fall = 0;
    for (int s = 0; s < kSensors; ++s) {
      fall += m.of[s].fall;
      TEST_ASSERT_DOUBLE_WITHIN(4 * m.of[s].sigma, 0, m.of[s].after);
      TEST_ASSERT_DOUBLE_WITHIN(4 * m.of[s].sigma, s == seen_by ? 0.25 : 0, m.of[s].before);
    }
    TEST_ASSERT_TRUE(m.of[seen_by].before > 5 * m.of[seen_by].sigma || seen_by > 0);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6 * m.fall + 0.02 * kTheta, m.fall, fall);  // theta's prior has the rest
  }
}

/// Degrees of freedom: rows less theta's, which each fold fits anew.
void test_degrees_of_freedom_add_up() {
  const Measured m = measured(recording_of(3, 0, kSensors, {1, 1, 1}));
  const double rows = kSegments * (kRows[0] + kRows[1] + kRows[2]);
  TEST_ASSERT_DOUBLE_WITHIN(0.05, rows - 4 * kTheta, m.of[0].dof + m.of[1].dof + m.of[2].dof);
  for (const SensorGap& gap : m.of) TEST_ASSERT_EQUAL_DOUBLE(1, gap.floor);
}

host::SimulationResult simulated(const std::string& effect) {
  host::SimulationOptions options;
  options.scenario = "rich";
  options.seconds = 40;
  options.seed = 1;
  if (!effect.empty()) options.effects.push_back(host::sim::parse_effect(effect));
  return host::simulate(options);
}

host::DiagnoseOptions options_of(const host::SimulationResult& session) {
  host::DiagnoseOptions out;
  out.core.calibration = session.nominal;
  out.core.noise = session.recording.imu.noise;
  return out;
}

/// The sensors' rows and the core's elimination are the same squares, with terms of the IMU and of the image, some of
/// them in the fit: the core's are float.
void test_rows_are_the_core_s() {
  const host::SimulationResult session = simulated("time_offset=0.003");
  const host::DiagnoseOptions options = options_of(session);
  const Catalogue catalogue = core_catalogue(false);
  const std::vector<host::Recording> sessions{session.recording};
  Budget budget(1);  // of no use to one fit
  Evidence evidence(sessions, options.core, "host", &budget, [](double) {});
  std::vector<bool> estimated(catalogue.terms.size(), false);
  estimated[0] = true;
  const Problem problem = evidence.fit(catalogue.terms, estimated, std::vector<double>(catalogue.terms.size(), 0));
  const SensorPieces pieces = evidence.sensors();
  double residuals_less_unknowns = 0, dof = 0;
  for (std::size_t i = 0; i < problem.pieces.size(); ++i) {
    const MatrixXd& R = problem.pieces[i].rows.R;
    const MatrixXd core = R.transpose() * R;
    MatrixXd sum = MatrixXd::Zero(R.cols(), R.cols());
    for (const auto& of : pieces.of) sum += of[i].rows.R.transpose() * of[i].rows.R;
    const VectorXd scale = core.diagonal().cwiseMax(1e-12).cwiseSqrt().cwiseInverse();
    const double apart = (scale.asDiagonal() * (sum - core) * scale.asDiagonal()).cwiseAbs().maxCoeff();
    // Float rows: 1e-3 to 2.5e-3 by segment.
    TEST_ASSERT_DOUBLE_WITHIN(4e-3, 0, apart);
    residuals_less_unknowns += problem.pieces[i].rows.dof - 6;  // the core's count takes weakly known biases as known
    dof += pieces.shared[i].sum();
    for (int s = 0; s < kSensors; ++s) TEST_ASSERT_TRUE(pieces.shared[i].row(s).minCoeff() >= 0);
  }
  std::printf("degrees of freedom: %.1f of the sensors, %.0f counted\n", dof, residuals_less_unknowns);
  TEST_ASSERT_DOUBLE_WITHIN(0.6 * static_cast<double>(problem.pieces.size()), residuals_less_unknowns,
                            dof);  // the core rounds each segment's
}

Diagnosis diagnosed(const std::string& effect) {
  const host::SimulationResult session = simulated(effect);
  const Diagnosis d = host::diagnose({session.recording}, options_of(session));
  const auto line = [](const char* what, const host::SensorShares& s) {
    std::printf("  %s %8.4f %8.4f %8.4f %8.4f\n", what, s.total, s.camera, s.gyro, s.accel);
  };
  std::printf("%s: %s, %.1f s\n", effect.c_str(), d.verdict.c_str(), d.seconds);
  line("before", d.before);
  line("after ", d.after);
  line("sigma ", d.gap_sigma);
  line("floor ", d.noise_floor);
  line("dof   ", d.gap_dof);
  return d;
}

void expect_closed(const host::SensorShares& excess, const host::SensorShares& sigma) {
  TEST_ASSERT_DOUBLE_WITHIN(4 * sigma.camera, 0, excess.camera);
  TEST_ASSERT_DOUBLE_WITHIN(4 * sigma.gyro, 0, excess.gyro);
  TEST_ASSERT_DOUBLE_WITHIN(4 * sigma.accel, 0, excess.accel);
}

void test_without_effect() {
  const Diagnosis d = diagnosed("");
  expect_closed(d.before, d.gap_sigma);
  TEST_ASSERT_EQUAL_DOUBLE(d.before.gyro, d.after.gyro);
  TEST_ASSERT_DOUBLE_WITHIN(0.05, 1, d.noise_floor.camera);
}

/// What an effect takes away: noise is the same in both.
host::SensorShares closed_by(const Diagnosis& d) {
  return {d.before.total - d.after.total, d.before.camera - d.after.camera, d.before.gyro - d.after.gyro,
          d.before.accel - d.after.accel};
}

/// Effects of the gyroscope are hardly anything that images see in themselves, and they close. One that is a clock's as
/// well, a lag, turns the attitude that the accelerometer is held against; g-sensitivity is the gyroscope's first.
void test_effects_of_the_gyroscope() {
  for (const char* effect : {"gyro_g_sensitivity=3e-4,0,0,0,3e-4,0,0,0,3e-4", "gyro_lag=0.004"}) {
    const Diagnosis d = diagnosed(effect);
    const host::SensorShares closed = closed_by(d);
    TEST_ASSERT_TRUE(closed.gyro > 3 * d.gap_sigma.gyro && closed.camera < 0.01 * closed.gyro);
    TEST_ASSERT_TRUE(closed.gyro > (effect[5] == 'g' ? 1.0 : 0.5) * closed.accel);
    expect_closed(d.after, d.gap_sigma);
  }
}

/// Only a lens disagrees with the images themselves.
void test_effects_of_the_camera() {
  const Diagnosis d = diagnosed("tangential_residual=4e-3,-4e-3");
  TEST_ASSERT_TRUE(closed_by(d).camera > 8 * d.gap_sigma.camera);
  expect_closed(d.after, d.gap_sigma);
}

void test_effects_of_the_accelerometer() {
  const Diagnosis d = diagnosed("accel_nonlinearity=1e-3,1e-3,1e-3");
  const host::SensorShares closed = closed_by(d);
  TEST_ASSERT_TRUE(closed.accel > 5 * d.gap_sigma.accel && closed.accel > 5 * closed.gyro);
  expect_closed(d.after, d.gap_sigma);
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_nothing_there_is_nothing_open);
  RUN_TEST(test_data_sheet_opens_nothing);
  RUN_TEST(test_sensors_that_do_not_add_up);
  RUN_TEST(test_the_sensor_that_sees_it);
  RUN_TEST(test_degrees_of_freedom_add_up);
  RUN_TEST(test_rows_are_the_core_s);
  RUN_TEST(test_without_effect);
  RUN_TEST(test_effects_of_the_gyroscope);
  RUN_TEST(test_effects_of_the_camera);
  RUN_TEST(test_effects_of_the_accelerometer);
  return UNITY_END();
}
