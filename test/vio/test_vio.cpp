// The filter on simulated devices: consistency, starts, standstill, faults, single against double precision.
#include <unity.h>

#include <cstdio>
#include <cstring>
#include <memory>

#include "vio_simulation.h"

using namespace vio_test;

void setUp(void) {}
void tearDown(void) {}

namespace {

/// Normalised squared error of three entries of the state.
double block_nees(const Vec<double, 15>& e, const Mat<double, 15, 15>& P, int first) {
  const Mat3<double> B = P.block<3, 3>(first, first);
  Mat3<double> L;
  if (!cholesky_lower<double, 3>(B, &L)) return 1e6;
  double sum = 0;
  Vec3<double> y;
  for (int i = 0; i < 3; ++i) {
    y(i) = e(first + i);
    for (int k = 0; k < i; ++k) y(i) -= L(i, k) * y(k);
    y(i) /= L(i, i);
    sum += y(i) * y(i);
  }
  return sum / 3;
}

struct Outcome {
  double attitude = 0, position = 0, velocity = 0, yaw = 0;  ///< mean normalised squared errors
  double worst_position = 0;                                 ///< m
  double still_drift = 0;                                    ///< m, from 1.5 s after the scene's rest_from
  double first_tracking = -1;                                ///< s
  int samples = 0;
  VioStatistics statistics;
};

/// Position may jump on a restart, so the gauge is fixed at every start.
template <class S>
Outcome run(const Scene& scene) {
  const Recording recording = simulate(scene);
  auto replay = std::make_unique<Replay<S>>(recording, options_for<S>(scene));
  Vio<S>& vio = replay->vio;
  Outcome out;
  Gauge gauge;
  int start = 0;
  Vec3<double> rest_place = Vec3<double>::Zero();
  bool resting = false;
  for (const TrueFrame& frame : recording.frames) {
    if (replay->push(frame) != VioStatus::tracking) continue;
    const double t = (frame.t_ns - 1000000000) * 1e-9;
    if (vio.statistics().starts != start) {
      start = vio.statistics().starts;
      if (out.first_tracking < 0) out.first_tracking = t;
      for (const TrueFrame& other : recording.frames) {
        if (other.t_ns == vio.window().pose[0].time) gauge.fix(vio.window().pose[0], other.x);
      }
    }
    Mat<S, 15, 15> covariance;
    vio.covariance(&covariance);
    const Mat<double, 15, 15> P = covariance.template cast<double>();
    const Vec<double, 15> e = gauge.error(vio.state(), frame.x);
    const Mat3<double> R_GI = vio.state().R_GI.template cast<double>();
    const double e_yaw = (R_GI * e.head<3>()).z();
    out.yaw += e_yaw * e_yaw / (R_GI * P.topLeftCorner<3, 3>() * R_GI.transpose())(2, 2);
    out.attitude += block_nees(e, P, 0);
    out.position += block_nees(e, P, 3);
    out.velocity += block_nees(e, P, 6);
    out.worst_position = std::max(out.worst_position, e.segment<3>(3).norm());
    ++out.samples;
    if (t < scene.rest_from + 1.5) continue;
    const Vec3<double> p = vio.state().p_GI.template cast<double>();
    if (!resting) rest_place = p;
    resting = true;
    out.still_drift = std::max(out.still_drift, (p - rest_place).norm());
  }
  out.statistics = vio.statistics();
  return out;
}

void note(const Scene& scene, const Outcome& out) {
  char line[200];
  std::snprintf(
      line, sizeof line,
      "seed %d: start %.1f s, mean NEES attitude %.2f position %.2f velocity %.2f yaw %.2f, worst %.3f m, restarts %d",
      static_cast<int>(scene.seed), out.first_tracking, out.attitude / out.samples, out.position / out.samples,
      out.velocity / out.samples, out.yaw / out.samples, out.worst_position, static_cast<int>(out.statistics.restarts));
  TEST_MESSAGE(line);
}

/// Mean NEES over seeds; each run must come through and stay near the path.
template <class S>
void check_consistency(Scene scene, int seeds, double limit_m) {
  double attitude = 0, position = 0, velocity = 0, yaw = 0;
  int samples = 0;
  for (int seed = 1; seed <= seeds; ++seed) {
    scene.seed = static_cast<std::uint64_t>(seed);
    const Outcome out = run<S>(scene);
    TEST_ASSERT_TRUE_MESSAGE(out.samples > 0, "never started");
    if (out.worst_position > limit_m || out.statistics.restarts) note(scene, out);
    TEST_ASSERT_TRUE_MESSAGE(out.worst_position < limit_m, "far from the path");
    TEST_ASSERT_EQUAL_INT(0, out.statistics.restarts);
    attitude += out.attitude;
    position += out.position;
    velocity += out.velocity;
    yaw += out.yaw;
    samples += out.samples;
  }
  char line[160];
  std::snprintf(line, sizeof line, "ANEES attitude %.2f position %.2f velocity %.2f yaw %.2f", attitude / samples,
                position / samples, velocity / samples, yaw / samples);
  TEST_MESSAGE(line);
  for (double sum : {attitude, position, velocity, yaw}) {
    TEST_ASSERT_TRUE_MESSAGE(sum / samples < 1.6, "too sure of itself");
    TEST_ASSERT_TRUE_MESSAGE(sum / samples > 0.25, "too unsure of itself");
  }
}

void consistent_from_a_start_in_motion(void) {
  check_consistency<double>(Scene(), 16, 0.15);
  check_consistency<float>(Scene(), 16, 0.15);
}

void consistent_with_wrong_intrinsics(void) {
  Scene scene;
  scene.focal_error = 0.015;
  check_consistency<float>(scene, 16, 0.15);
}

void consistent_with_an_uncalibrated_imu(void) {
  Scene scene;
  scene.imu_error = 0.012;
  check_consistency<float>(scene, 16, 0.2);
}

/// As trackers drift (docs/results.md, "Measured data"). Taken for white noise of 0.3 px, it is too sure of itself.
void consistent_with_tracks_that_walk(void) {
  Scene scene;
  scene.pixel_noise = 0.3;
  scene.track_walk = 0.9;
  check_consistency<float>(scene, 16, 0.2);
}

void consistent_with_two_cameras(void) {
  Scene scene;
  scene.cameras = 2;
  scene.tracks = 90;
  check_consistency<float>(scene, 16, 0.15);
  scene.focal_error = 0.015;
  scene.imu_error = 0.012;
  check_consistency<float>(scene, 16, 0.2);
}

void two_cameras_at_rest(void) {
  Scene scene;
  scene.cameras = 2;
  scene.rest_until = 3;
  check_consistency<float>(scene, 5, 0.15);
  const Outcome out = run<float>(scene);
  TEST_ASSERT_GREATER_THAN(15, out.statistics.standstill_frames);
}

void consistent_with_mismatched_tracks(void) {
  Scene scene;
  scene.outliers = 0.1;
  check_consistency<float>(scene, 10, 0.2);
}

void starts_at_rest(void) {
  Scene scene;
  scene.rest_until = 3;
  check_consistency<float>(scene, 10, 0.15);
  const Outcome out = run<float>(scene);
  TEST_ASSERT_TRUE_MESSAGE(out.first_tracking < 1.0, "half a second of rest is enough");
  TEST_ASSERT_GREATER_THAN(15, out.statistics.standstill_frames);
}

void starts_in_motion_within_two_seconds(void) {
  for (int seed = 101; seed <= 110; ++seed) {
    Scene scene;
    scene.seconds = 4;
    scene.seed = static_cast<std::uint64_t>(seed);
    const Outcome out = run<float>(scene);
    if (!(out.first_tracking > 0 && out.first_tracking < 2)) note(scene, out);
    TEST_ASSERT_TRUE(out.first_tracking > 0 && out.first_tracking < 2);
  }
}

void standing_still_does_not_drift(void) {
  for (int seed = 1; seed <= 5; ++seed) {
    Scene scene;
    scene.seconds = 30;
    scene.rest_from = 10;
    scene.seed = static_cast<std::uint64_t>(seed);
    const Outcome out = run<float>(scene);
    if (out.still_drift > 0.01) note(scene, out);
    TEST_ASSERT_TRUE_MESSAGE(out.still_drift < 0.01, "more than 1 cm in 18 s");
    TEST_ASSERT_GREATER_THAN(150, out.statistics.standstill_frames);
  }
}

/// Frames [from, to) are taken out of the recording, or emptied of points.
Outcome run_with_hole(int from, int to, bool keep_empty, VioStatus* at_hole, bool* running_at_end) {
  Scene scene;
  const Recording recording = simulate(scene);
  auto replay = std::make_unique<Replay<float>>(recording, options_for<float>(scene));
  Outcome out;
  for (int k = 0; k < static_cast<int>(recording.frames.size()); ++k) {
    TrueFrame frame = recording.frames[k];
    const bool hole = k >= from && k < to;
    if (hole && !keep_empty) continue;
    if (hole) frame.points.clear();
    const VioStatus status = replay->push(frame);
    if (status == VioStatus::lost) *at_hole = status;
  }
  out.statistics = replay->vio.statistics();
  *running_at_end = replay->vio.initialised();
  return out;
}

void a_gap_restarts(void) {
  VioStatus status = VioStatus::tracking;
  bool running = false;
  const Outcome out = run_with_hole(80, 95, false, &status, &running);
  TEST_ASSERT_EQUAL_INT(1, out.statistics.restarts);
  TEST_ASSERT_EQUAL_INT(static_cast<int>(VioStatus::lost), static_cast<int>(status));
  TEST_ASSERT_EQUAL_INT(2, out.statistics.starts);
  TEST_ASSERT_TRUE(running);
}

void lost_tracks_restart(void) {
  VioStatus status = VioStatus::tracking;
  bool running = false;
  const Outcome out = run_with_hole(80, 120, true, &status, &running);
  TEST_ASSERT_GREATER_OR_EQUAL(1, out.statistics.restarts);
  TEST_ASSERT_GREATER_OR_EQUAL(2, out.statistics.starts);
  TEST_ASSERT_TRUE(running);
}

void a_short_blackout_is_survived(void) {
  VioStatus status = VioStatus::tracking;
  bool running = false;
  const Outcome out = run_with_hole(80, 84, true, &status, &running);
  TEST_ASSERT_EQUAL_INT(0, out.statistics.restarts);
  TEST_ASSERT_TRUE(running);
}

void float_agrees_with_double(void) {
  const Recording recording = simulate(Scene());
  auto single = std::make_unique<Replay<float>>(recording, options_for<float>(Scene()));
  auto twice = std::make_unique<Replay<double>>(recording, options_for<double>(Scene()));
  double worst = 0;
  for (const TrueFrame& frame : recording.frames) {
    const VioStatus a = single->push(frame), b = twice->push(frame);
    TEST_ASSERT_EQUAL_INT(static_cast<int>(b), static_cast<int>(a));
    if (a != VioStatus::tracking) continue;
    const Vec3<double> d = single->vio.state().p_GI.cast<double>() - twice->vio.state().p_GI;
    Mat<double, 15, 15> P;
    twice->vio.covariance(&P);
    worst = std::max(worst, d.norm() / std::sqrt(P(3, 3) + P(4, 4) + P(5, 5)));
  }
  char line[80];
  std::snprintf(line, sizeof line, "largest difference of positions: %.3f sigma", worst);
  TEST_MESSAGE(line);
  TEST_ASSERT_TRUE(worst < 0.3);
}

void dirty_memory_gives_the_same_bits(void) {
  const Recording recording = simulate(Scene());
  State<float> last[2];
  for (int dirty = 0; dirty < 2; ++dirty) {
    auto replay = std::make_unique<Replay<float>>(recording, options_for<float>(Scene()));
    std::memset(static_cast<void*>(&replay->vio), dirty ? 0xFF : 0, sizeof replay->vio);
    replay->vio.reset(cast<float>(recording.initial), options_for<float>(Scene()));
    for (int k = 0; k < 100; ++k) replay->push(recording.frames[k]);
    last[dirty] = replay->vio.state();
  }
  TEST_ASSERT_EQUAL_MEMORY(last[0].p_GI.data(), last[1].p_GI.data(), sizeof(float) * 3);
  TEST_ASSERT_EQUAL_MEMORY(last[0].R_GI.data(), last[1].R_GI.data(), sizeof(float) * 9);
}

void a_new_calibration_enters_the_running_filter(void) {
  Scene scene;
  scene.r_CI_error = 0.02;
  scene.focal_error = 0.015;
  const Recording recording = simulate(scene);
  auto replay = std::make_unique<Replay<float>>(recording, options_for<float>(scene));
  int tracked = 0;
  for (int k = 0; k < static_cast<int>(recording.frames.size()); ++k) {
    if (k == 60) replay->vio.set_calibration(cast<float>(recording.truth));
    if (replay->push(recording.frames[k]) == VioStatus::tracking && k >= 60) ++tracked;
  }
  TEST_ASSERT_EQUAL_INT(0, replay->vio.restarts());
  TEST_ASSERT_EQUAL_INT(static_cast<int>(recording.frames.size()) - 60, tracked);
  const Vec3<float> r = so3_log<float>(replay->vio.R_CI(0) * recording.truth.camera[0].R_CI.cast<float>().transpose());
  TEST_ASSERT_TRUE(r.norm() < 0.01f);
}

/// By how much the way of two seconds disagrees with the true one, from the tenth second on, at which the filter is
/// `given` the truth; m.
double drift_after_release(const Recording& recording, const Scene& scene, bool given) {
  auto replay = std::make_unique<Replay<float>>(recording, options_for<float>(scene));
  Gauge gauge;
  bool started = false;
  Vec3<double> before = Vec3<double>::Zero();
  double most = 0;
  for (int k = 0; k < 120; ++k) {
    const TrueFrame& frame = recording.frames[k];
    if (replay->push(frame) != VioStatus::tracking) continue;
    if (!started) gauge.fix(replay->vio.window().newest(), frame.x);
    started = true;
    if (k == 99 && given) replay->vio.set_calibration(cast<float>(recording.truth));
    const Vec3<double> e = gauge.error(replay->vio.state(), frame.x).segment<3>(3);
    if (k == 99) before = e;
    if (k > 99) most = std::max(most, (e - before).norm());
  }
  return most;
}

/// A calibration changes what the filter believes of its sensors, not how sure it is of them: with a prior as wide as
/// at the start it would learn them anew from a few frames, and place, heading and velocity would move along.
void a_new_calibration_does_not_shake_the_path(void) {
  double plain = 0, given = 0;
  for (int seed = 1; seed <= 12; ++seed) {
    Scene scene;
    scene.seed = seed;
    scene.focal_error = 0.015;
    scene.imu_error = 0.01;
    const Recording recording = simulate(scene);
    const double a = drift_after_release(recording, scene, false), b = drift_after_release(recording, scene, true);
    std::printf("seed %d: the way of two seconds is %.1f mm off, with a release %.1f mm\n", seed, 1e3 * a, 1e3 * b);
    plain += a / 12;
    given += b / 12;
  }
  std::printf("mean: %.1f mm, with a release %.1f mm\n", 1e3 * plain, 1e3 * given);
  // The truth makes the way better, not worse.
  TEST_ASSERT_TRUE(given < 1.05 * plain);
}

/// Mirrored images contradict the IMU.
void a_wrong_filter_gives_up_soon(void) {
  const Recording recording = simulate(Scene());
  auto replay = std::make_unique<Replay<float>>(recording, options_for<float>(Scene()));
  int lost_at = -1;
  for (int k = 0; k < 120 && lost_at < 0; ++k) {
    TrueFrame frame = recording.frames[k];
    for (TrackPoint<double>& point : frame.points) {
      if (k >= 80) point.uv.x() = 640 - point.uv.x();
    }
    if (replay->push(frame) == VioStatus::lost) lost_at = k;
  }
  TEST_ASSERT_TRUE(lost_at >= 80 && lost_at < 110);
}

/// A jolt that only the accelerometer feels leaves a wrong velocity just before rest; then IMU and image both say rest.
void a_filter_that_denies_rest_gives_up(void) {
  Scene scene;
  scene.rest_from = 8;
  Recording recording = simulate(scene);
  for (std::size_t i = 0; i < recording.imu.size(); ++i) {
    const double t = static_cast<double>(i) * 0.005;
    if (t > 7.5 && t < 8) recording.imu[i].accel += Vec3<double>(4, -3, 0);
  }
  auto replay = std::make_unique<Replay<float>>(recording, options_for<float>(scene));
  bool running = false;
  for (const TrueFrame& frame : recording.frames) running = replay->push(frame) == VioStatus::tracking;
  TEST_ASSERT_GREATER_OR_EQUAL(1, replay->vio.restarts());
  TEST_ASSERT_TRUE(running && replay->vio.standing_still());
  TEST_ASSERT_TRUE(replay->vio.state().v_GI.norm() < 0.02f);
}

void a_fold_can_be_taken_back(void) {
  auto w = std::make_unique<Window<float>>();
  std::memset(static_cast<void*>(w.get()), 0, sizeof *w);
  w->reset(cast<float>(simulated_device()));
  Random random(1);
  const int n = w->columns(), rows = 12, first = pose_column(2);
  for (int i = 0; i < packed_size(n + 1); ++i) w->triangle[i] = static_cast<float>(random.normal(100));
  std::vector<float> before(w->triangle, w->triangle + packed_size(n + 1));
  w->clear_block(rows);
  for (int i = 0; i < rows; ++i) {
    for (int c = first; c <= n; ++c) w->block[i * kBlockStride + c] = static_cast<float>(random.normal(100));
  }
  fold_block(w.get(), w->block, rows, first);
  unfold_block(w.get(), w->block, rows, first);
  for (int i = 0; i < packed_size(n + 1); ++i) TEST_ASSERT_FLOAT_WITHIN(0.02f, before[i], w->triangle[i]);
}

void frames_wait_for_the_imu_and_keep_their_distance(void) {
  const Recording recording = simulate(Scene());
  auto vio = std::make_unique<Vio<float>>();
  auto imu = std::make_unique<ImuHistory<float>>();
  imu->clear();
  vio->reset(cast<float>(recording.initial), VioOptions<float>());
  TEST_ASSERT_TRUE(vio->push_frame(1000000000, nullptr, 0, *imu) == VioStatus::waiting);
  for (int i = 0; i < 60; ++i) {
    imu->push(recording.imu_time[i], {recording.imu[i].gyro.cast<float>(), recording.imu[i].accel.cast<float>()});
  }
  TEST_ASSERT_TRUE(vio->push_frame(1100000000, nullptr, 0, *imu) == VioStatus::initialising);
  TEST_ASSERT_TRUE(vio->push_frame(1100000000, nullptr, 0, *imu) == VioStatus::skipped);
  TEST_ASSERT_TRUE(vio->push_frame(1150000000, nullptr, 0, *imu) == VioStatus::skipped);
  TEST_ASSERT_TRUE(vio->push_frame(1199500000, nullptr, 0, *imu) == VioStatus::initialising);
  TEST_ASSERT_TRUE(vio->push_frame(9000000000, nullptr, 0, *imu) == VioStatus::waiting);
}

}  // namespace

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(consistent_from_a_start_in_motion);
  RUN_TEST(consistent_with_wrong_intrinsics);
  RUN_TEST(consistent_with_an_uncalibrated_imu);
  RUN_TEST(consistent_with_tracks_that_walk);
  RUN_TEST(consistent_with_two_cameras);
  RUN_TEST(two_cameras_at_rest);
  RUN_TEST(consistent_with_mismatched_tracks);
  RUN_TEST(starts_at_rest);
  RUN_TEST(starts_in_motion_within_two_seconds);
  RUN_TEST(standing_still_does_not_drift);
  RUN_TEST(a_gap_restarts);
  RUN_TEST(lost_tracks_restart);
  RUN_TEST(a_short_blackout_is_survived);
  RUN_TEST(float_agrees_with_double);
  RUN_TEST(dirty_memory_gives_the_same_bits);
  RUN_TEST(a_new_calibration_enters_the_running_filter);
  RUN_TEST(a_new_calibration_does_not_shake_the_path);
  RUN_TEST(a_wrong_filter_gives_up_soon);
  RUN_TEST(a_filter_that_denies_rest_gives_up);
  RUN_TEST(a_fold_can_be_taken_back);
  RUN_TEST(frames_wait_for_the_imu_and_keep_their_distance);
  return UNITY_END();
}
