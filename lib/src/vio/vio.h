// Visual-inertial odometry: a multi-state constraint filter in square-root information form.
//
// Mourikis and Roumeliotis 2007 (MSCKF): past camera poses stay in the state, landmarks are eliminated.
// Wu et al. 2015 (square-root inverse filter): the state's information is an upper triangle R, which single precision
// can hold. Huang et al. (first-estimate Jacobians): the filter must not learn its place or heading from nothing.
// The extrinsics are states of the filter (paper, Sec. IV-B); so are, unless switched off, the intrinsics of camera and
// IMU (as in Li et al. 2014): a wrong focal length would otherwise be explained by a wrong lever arm p_CI, and a per
// cent of accelerometer scale (0.1 m/s^2 of gravity, turning with the device) by wrong tilt, velocity and scale.
#pragma once

#include "vio/global_shutter.h"
#include "vio/sensor_priors.h"
#include "vio/standstill.h"
#include "vio/start_motion.h"
#include "vio/vio_propagate.h"
#include "vio/vio_tracks.h"
#include "vio/vio_types.h"
#include "vio/vio_update.h"
#include "vio/window_covariance.h"

namespace SEGCAL_NS {

/// All memory is inside. The storage may hold anything before reset().
/// So many frames in a row at which the device rests but the filter moves are a lost filter.
constexpr int kDeniedRest = 5;

template <class S>
class Vio {
 public:
  [[gnu::cold]] Vio() = default;

  /// Forgets everything and waits for frames.
  [[gnu::cold]] void reset(const Calibration<S>& theta, const VioOptions<S>& options);

  /// The same for one that has run before; its counts go on.
  [[gnu::cold]] void restart(const Calibration<S>& theta, const VioOptions<S>& options) {
    const VioStatistics counted = statistics_;
    reset(theta, options);
    statistics_ = counted;
    statistics_.frames_waited = statistics_.starts_tried = 0;
  }

  /// A new calibration for the running filter: in place of its own, which it knows as well as before (sensor_priors.h).
  void set_calibration(const Calibration<S>& theta);
  /// See VioOptions::late_start_at_once.
  void finish_late_starts(bool at_once) { options_.late_start_at_once = at_once; }
  /// Of terms that follow the time.
  void set_time_zero(std::int64_t t_ns) {
    window_.theta.effects.time_zero_ns = window_.given.effects.time_zero_ns = t_ns;
  }

  /// Forgets place and motion and waits for frames, but keeps what was learnt about the sensors, with its information.
  void next_session();

  /// A start in motion waits for slices.
  bool start_pending() const { return starting_ && motion_.pending(); }
  /// One of them. Until a frame comes that is late enough for it to take effect, nobody sees what it did.
  void start_step(const ImuHistory<S>& imu) { motion_.step(start_context(), imu); }
  /// All that is left of them; false if there was nothing.
  bool finish_start(const ImuHistory<S>& imu) {
    const bool pending = start_pending();
    while (start_pending()) start_step(imu);
    return pending;
  }

  /// The next frame of all cameras, stamps in IMU time. `imu` must cover the time since the last frame up to t_ns.
  VioStatus push_frame(std::int64_t t_ns, const TrackPoint<S>* points, int n, const ImuHistory<S>& imu);

  bool initialised() const { return running_; }
  /// No frame has been used yet, or since it was lost.
  bool collecting() const { return !running_ && !starting_; }
  /// State of the IMU at time(); only when initialised.
  const State<S>& state() const { return window_.now; }
  std::int64_t time() const { return time_; }
  /// Places count from `by` from now on; only when initialised.
  void move_origin(const Vec3<S>& by) { window_.move_origin(by); }
  /// Covariance of state(), error order [theta p v b_a b_g].
  void covariance(Mat<S, kStateColumns, kStateColumns>* P) { state_covariance(&window_, P); }

  /// The calibration that the filter runs with; its cameras are the filter's own estimates.
  const Calibration<S>& calibration() const { return running_ ? window_.theta : window_.given; }
  /// Information on it, as a triangle over theta's columns and a right-hand side of zero, in the filter's own memory
  /// until the next call of anything else; only where knows_sensors().
  PackedTriangle<S> calibration_information() {
    PackedTriangle<S> R(window_.block, calibration().columns() + 1);
    sensor_triangle(&window_, &R);
    return R;
  }
  /// It runs, or has learnt about the sensors in an earlier session.
  bool knows_sensors() const { return running_ || window_.learnt; }
  const Mat3<S>& R_CI(int camera) const { return window_.theta.camera[camera].R_CI; }
  const Vec3<S>& p_CI(int camera) const { return window_.theta.camera[camera].p_CI; }
  /// Standard deviations of (r_CI 3, p_CI 3).
  void extrinsic_sigma(int camera, Vec<S, kExtrinsicColumns>* sigma) { extrinsics_sigma(&window_, camera, sigma); }

  const VioStatistics& statistics() const { return statistics_; }
  std::int32_t restarts() const { return statistics_.restarts; }
  /// Factor on pixel_sigma that the residuals ask for (1 when the calibration fits).
  S pixel_scale() const { return monitor_.scale; }
  bool standing_still() const { return still_; }
  /// Poses in the window and their first estimates.
  const Window<S>& window() const { return window_; }

 private:
  VioStatus collect(std::int64_t t_ns, const TrackPoint<S>* points, int n, const ImuHistory<S>& imu);
  VioStatus track(std::int64_t t_ns, const TrackPoint<S>* points, int n, const ImuHistory<S>& imu);
  VioStatus wait_for_start(std::int64_t t_ns, const TrackPoint<S>* points, int n, const ImuHistory<S>& imu);
  [[gnu::cold]] VioStatus try_to_start(std::int64_t t_ns, const ImuHistory<S>& imu);
  VioStatus begin_running();
  void forget_oldest_frame();
  StartContext<S> start_context() { return {&window_, &tracks_, &start_, options_, origin_, &monitor_, &statistics_}; }
  [[gnu::cold]] VioStatus give_up();
  [[gnu::cold]] void forget();
  void make_room();
  bool healthy() const;
  void move_on(std::int64_t t_ns, const TrackPoint<S>* points, int n, const ImuIntegral<S>& I, int place, int spent);
  const TrackPoint<S>* at_stamp(std::int64_t t_ns, const TrackPoint<S>* points, int n, const ImuHistory<S>& imu);

  VioOptions<S> options_;
  Window<S> window_;
  TrackTable<S> tracks_;
  StartScratch<S> start_;
  MotionStart<S> motion_;
  ResidualMonitor<S> monitor_;
  TrackPoint<S> at_stamp_[kHasLineDelay ? kMaxVioTracks : 1];  ///< of the present frame, see global_shutter.h
  Origin<S> origin_;  ///< where the next start places the device: the last place known
  VioStatistics statistics_;
  std::int64_t time_, last_update_;  ///< of the newest pose; of the last feature
  std::int64_t arrived_;             ///< newest frame, whether it became a pose or not
  std::int64_t waiting_since_;       ///< first try of a start in motion
  std::int64_t start_due_;           ///< a start takes effect at the first frame from then on
  std::int32_t denied_rest_;         ///< frames in a row at rest beyond doubt that the filter takes for motion
  std::int32_t place_kept_;          ///< frames in a row that rocked in place, as far as the window reaches
  bool running_, still_;
  bool starting_;  ///< in motion, from the frames in the window
};

template <class S>
[[gnu::cold]] void Vio<S>::reset(const Calibration<S>& theta, const VioOptions<S>& options) {
  options_ = options;
  window_.reset(theta);
  origin_ = Origin<S>();
  statistics_ = VioStatistics();
  monitor_ = ResidualMonitor<S>();
  time_ = arrived_ = INT64_MIN;
  starting_ = false;
  forget();
}

template <class S>
void Vio<S>::forget() {
  // Slices of a start may have moved the calibration and folded into the rows of the sensors; it must not matter which.
  if (starting_) window_.restore_calibration();
  running_ = still_ = starting_ = false;
  motion_.cancel();
  denied_rest_ = place_kept_ = 0;
  window_.clear();
  tracks_.clear(window_.theta.n_cameras);
}

template <class S>
void Vio<S>::set_calibration(const Calibration<S>& theta) {
  if (running_) {
    take_calibration(theta, &window_);
  } else {
    window_.replace_calibration(theta);
  }
}

template <class S>
void Vio<S>::next_session() {
  if (running_) {
    window_.learnt = true;
    window_.given = window_.theta;
  }
  origin_ = Origin<S>();
  monitor_ = ResidualMonitor<S>();
  statistics_.frames_waited = statistics_.starts_tried = 0;
  time_ = arrived_ = INT64_MIN;
  forget();
}

/// The points as the filter takes them: as they are where all lines are exposed at once.
template <class S>
[[gnu::cold, gnu::noinline]] const TrackPoint<S>* Vio<S>::at_stamp(std::int64_t t_ns, const TrackPoint<S>* points,
                                                                   int n, const ImuHistory<S>& imu) {
  const Calibration<S>& theta = calibration();
  const S line_delay = theta.effects.value_of(kLineDelayTerm);
  if (!kHasLineDelay || line_delay == S(0) || n > kMaxVioTracks || !imu.covers(t_ns, t_ns)) return points;
  const RateAbout<S> rate(imu, t_ns, theta.imu, running_ ? window_.now.b_g : Vec3<S>(Vec3<S>::Zero()));
  for (int i = 0; i < n; ++i) {
    at_stamp_[i] = points[i];
    if (points[i].camera < 0 || points[i].camera >= theta.n_cameras || !is_finite(points[i].uv.sum())) continue;
    turn_to_stamp(theta.camera[points[i].camera], line_delay, rate, &at_stamp_[i].uv);
  }
  return at_stamp_;
}

template <class S>
VioStatus Vio<S>::push_frame(std::int64_t t_ns, const TrackPoint<S>* points, int n, const ImuHistory<S>& imu) {
  if (imu.size() < 2 || imu.newest() < t_ns) return VioStatus::waiting;
  const bool first = arrived_ == INT64_MIN;
  if (!first && t_ns <= arrived_) return VioStatus::skipped;
  // One millisecond of grace: stamps jitter, and 0.0999 s is meant to be 0.1 s.
  if (!first && S(t_ns - arrived_) * S(1e-9) < options_.frame_interval_s - S(1e-3)) return VioStatus::skipped;
  ++statistics_.frames;
  const bool gap = !first && (S(t_ns - arrived_) * S(1e-9) > options_.max_gap_s || !imu.covers(arrived_, t_ns));
  if (gap && running_) {
    time_ = arrived_ = t_ns;
    return give_up();
  }
  if (gap) forget();
  points = at_stamp(t_ns, points, n, imu);
  if (starting_) return wait_for_start(t_ns, points, n, imu);
  return running_ ? track(t_ns, points, n, imu) : collect(t_ns, points, n, imu);
}

}  // namespace SEGCAL_NS

#include "vio/vio_starting.h"
#include "vio/vio_tracking.h"
