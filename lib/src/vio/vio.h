// Visual-inertial odometry: a multi-state constraint filter in square-root information form.
//
// Mourikis and Roumeliotis 2007 (MSCKF): past camera poses stay in the state, landmarks are eliminated.
// Wu et al. 2015 (square-root inverse filter): the state's information is an upper triangle R, which single precision
// can hold. Huang et al. (first-estimate Jacobians): the filter must not learn its place or heading from nothing.
// The extrinsics are states of the filter (paper, Sec. IV-B); so are, unless switched off, the intrinsics of camera and
// IMU (as in Li et al. 2014): a wrong focal length would otherwise be explained by a wrong lever arm p_CI, and a per cent
// of accelerometer scale (0.1 m/s^2 of gravity, turning with the device) by wrong tilt, velocity and scale.
#pragma once

#include "vio/standstill.h"
#include "vio/start_motion.h"
#include "vio/vio_propagate.h"
#include "vio/vio_tracks.h"
#include "vio/vio_types.h"
#include "vio/vio_update.h"
#include "vio/vio_window.h"

namespace SEGCAL_NS {

/// All memory is inside. The storage may hold anything before reset().
/// So many frames in a row at which the device rests but the filter moves are a lost filter.
constexpr int kDeniedRest = 5;

template <class S>
class Vio {
 public:
  /// Forgets everything and waits for frames.
  void reset(const Calibration<S>& theta, const VioOptions<S>& options);

  /// A new calibration for the running filter. It replaces the filter's own, with a smaller prior.
  void set_calibration(const Calibration<S>& theta);
  /// See VioOptions::late_start_at_once.
  void finish_late_starts(bool at_once) { options_.late_start_at_once = at_once; }
  /// Of terms that follow the time.
  void set_time_zero(std::int64_t t_ns) { window_.theta.effects.time_zero_ns = window_.given.effects.time_zero_ns = t_ns; }

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
  /// State of the IMU at time(); only when initialised.
  const State<S>& state() const { return window_.now; }
  std::int64_t time() const { return time_; }
  /// Places count from `by` from now on; only when initialised.
  void move_origin(const Vec3<S>& by) { window_.move_origin(by); }
  /// Covariance of state(), error order [theta p v b_a b_g].
  void covariance(Mat<S, kStateColumns, kStateColumns>* P) { state_covariance(&window_, P); }

  /// The calibration that the filter runs with; its cameras are the filter's own estimates.
  const Calibration<S>& calibration() const { return running_ ? window_.theta : window_.given; }
  /// Information on it, as a triangle over theta's columns and a right-hand side of zero; only
  /// where knows_sensors().
  void calibration_information(PackedTriangle<S>* out) { sensor_triangle(&window_, out); }
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
  /// Memory for a triangle over theta and a right-hand side, until the next call of anything else.
  S* scratch() { return window_.block; }
  /// Poses in the window and their first estimates.
  const Window<S>& window() const { return window_; }

 private:
  VioStatus collect(std::int64_t t_ns, const TrackPoint<S>* points, int n, const ImuHistory<S>& imu);
  VioStatus track(std::int64_t t_ns, const TrackPoint<S>* points, int n, const ImuHistory<S>& imu);
  VioStatus wait_for_start(std::int64_t t_ns, const TrackPoint<S>* points, int n, const ImuHistory<S>& imu);
  VioStatus try_to_start(std::int64_t t_ns, const ImuHistory<S>& imu);
  VioStatus begin_running();
  void drop_start();
  StartContext<S> start_context() {
    return {&window_, &tracks_, &start_, options_, origin_, &monitor_, &statistics_};
  }
  VioStatus give_up();
  void forget();
  void make_room();
  bool healthy() const;
  void move_on(std::int64_t t_ns, const TrackPoint<S>* points, int n, const ImuIntegral<S>& I, int place);

  VioOptions<S> options_;
  Window<S> window_;
  TrackTable<S> tracks_;
  StartScratch<S> start_;
  MotionStart<S> motion_;
  ResidualMonitor<S> monitor_;
  Origin<S> origin_;  ///< where the next start places the device: the last place known
  VioStatistics statistics_;
  std::int64_t time_, last_update_;   ///< of the newest pose; of the last feature
  std::int64_t arrived_;      ///< newest frame, whether it became a pose or not
  std::int64_t start_due_;    ///< a start takes effect at the first frame from then on
  std::int32_t denied_rest_;  ///< frames in a row at rest beyond doubt that the filter takes for motion
  std::int32_t place_kept_;   ///< frames in a row that rocked in place, as far as the window reaches
  bool running_, still_;
  bool starting_;             ///< in motion, from the frames in the window
};

/// So many samples, and a few, come in the time of the window's last two frames.
template <class S>
int samples_until_next_frame(const ImuHistory<S>& imu, const Window<S>& w) {
  const int n = imu.at_or_before(w.newest().time) - imu.at_or_before(w.pose[w.n_poses - 2].time);
  return n + n / 4 + 2;
}

template <class S>
void Vio<S>::reset(const Calibration<S>& theta, const VioOptions<S>& options) {
  options_ = options;
  window_.reset(theta);
  origin_ = Origin<S>();
  statistics_ = VioStatistics();
  monitor_ = ResidualMonitor<S>();
  time_ = arrived_ = INT64_MIN;
  forget();
}

template <class S>
void Vio<S>::forget() {
  running_ = still_ = starting_ = false;
  motion_.cancel();
  denied_rest_ = place_kept_ = 0;
  window_.clear();
  tracks_.clear(window_.theta.n_cameras);
}

template <class S>
void Vio<S>::set_calibration(const Calibration<S>& theta) {
  if (running_) {
    take_calibration(theta, options_, &window_);
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
  time_ = arrived_ = INT64_MIN;
  forget();
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
  if (starting_) return wait_for_start(t_ns, points, n, imu);
  return running_ ? track(t_ns, points, n, imu) : collect(t_ns, points, n, imu);
}

/// Frames pile up in the window until gravity, velocity and biases can be told.
template <class S>
VioStatus Vio<S>::collect(std::int64_t t_ns, const TrackPoint<S>* points, int n, const ImuHistory<S>& imu) {
  if (!imu.covers(t_ns, t_ns)) return VioStatus::skipped;
  time_ = arrived_ = t_ns;
  while (window_.n_poses == kWindow || (window_.n_poses > 0 && !imu.covers(window_.pose[0].time, t_ns))) {
    tracks_.forget_slot(window_.pose[0].slot);
    window_.forget_oldest();
  }
  ++statistics_.frames_waited;
  const int slot = window_.append_empty(t_ns);
  statistics_.dropped_points += tracks_.observe(slot, points, n);
  tracks_.remove_ended_shorter_than(3);
  return try_to_start(t_ns, imu);
}

template <class S>
VioStatus Vio<S>::try_to_start(std::int64_t t_ns, const ImuHistory<S>& imu) {
  start_.link = lend_start_links(&window_);
  if (window_at_rest(window_, tracks_, options_, imu)) {
    start_at_rest(&window_, &tracks_, options_, origin_, imu, &start_);
    monitor_ = ResidualMonitor<S>();
    return begin_running();
  }
  if (window_.n_poses < kStartFrames) return VioStatus::initialising;
  motion_.begin(window_, imu);
  start_due_ = t_ns + std::int64_t(SEGCAL_START_DELAY_MS) * 1000000;
  const bool in_background = start_due_ > t_ns;
  if (in_background && !motion_.keeps_samples(imu, samples_until_next_frame(imu, window_))) {
    motion_.cancel();   // the samples would be gone before there is time for it
    return VioStatus::initialising;
  }
  ++statistics_.starts_tried;
  starting_ = true;
  if (in_background) return VioStatus::initialising;
  finish_start(imu);
  starting_ = false;
  return motion_.succeeded() ? begin_running() : VioStatus::initialising;
}

/// What its slices have moved so far is not to be used.
template <class S>
void Vio<S>::drop_start() {
  motion_.give_cameras_back(start_context());
  forget();
}

/// Frames between those of the start and its effect are let go: features are tracked over the gap. A start that is late takes
/// effect at a later frame, as long as its samples are there.
template <class S>
VioStatus Vio<S>::wait_for_start(std::int64_t t_ns, const TrackPoint<S>* points, int n, const ImuHistory<S>& imu) {
  arrived_ = t_ns;
  if (!motion_.keeps_samples(imu, 0)) {   // no frame came in time
    drop_start();
    return collect(t_ns, points, n, imu);
  }
  const bool last_chance = !motion_.keeps_samples(imu, samples_until_next_frame(imu, window_));
  // One millisecond of grace, as for the frames' distance.
  if (t_ns < start_due_ - 1000000 && !last_chance) return VioStatus::initialising;
  if (start_pending() && !options_.late_start_at_once) {
    ++statistics_.late_starts;
    if (!last_chance) return VioStatus::initialising;
    drop_start();
    return collect(t_ns, points, n, imu);
  }
  if (finish_start(imu)) ++statistics_.late_starts;
  starting_ = false;
  if (!motion_.succeeded()) return collect(t_ns, points, n, imu);
  const VioStatus begun = begin_running();
  return begun == VioStatus::tracking ? track(t_ns, points, n, imu) : begun;
}

/// From the window as a start has left it.
template <class S>
VioStatus Vio<S>::begin_running() {
  running_ = true;
  still_ = start_.still;
  ++statistics_.starts;
  statistics_.frames_waited = statistics_.starts_tried = 0;
  last_update_ = time_;
  return healthy() ? VioStatus::tracking : give_up();
}

template <class S>
VioStatus Vio<S>::track(std::int64_t t_ns, const TrackPoint<S>* points, int n, const ImuHistory<S>& imu) {
  const StillTest<S> test{options_, window_, tracks_, imu};
  still_ = test.still(t_ns, still_, points, n);
  const ImuIntegral<S> I = integral_between(window_, options_, imu, window_.now, time_, t_ns);
  if (still_) still_ = propagate_still(&window_, options_, I, test.shaking(t_ns));
  if (still_) {
    ++statistics_.standstill_frames;
    last_update_ = t_ns;
    denied_rest_ = 0;
    statistics_.dropped_points += tracks_.keep_alive(window_.newest().slot, points, n);
    use_ended_tracks(&window_, &tracks_, options_, &monitor_, &statistics_);
  } else {
    denied_rest_ = test.rests(t_ns, points, n) ? denied_rest_ + 1 : 0;
    const Mat3<S> R_GI = window_.now.R_GI * I.dR;
    move_on(t_ns, points, n, I, test.place_kept(R_GI, monitor_.nearness, place_kept_, points, n));
  }
  time_ = arrived_ = t_ns;
  window_.newest().time = t_ns;
  return healthy() ? VioStatus::tracking : give_up();
}

/// A new pose enters the window, features are used, the oldest pose leaves. `place`: the pose whose place it has not
/// left, or -1.
template <class S>
void Vio<S>::move_on(std::int64_t t_ns, const TrackPoint<S>* points, int n, const ImuIntegral<S>& I, int place) {
  const int slot = propagate(&window_, options_, I, t_ns);
  const bool held = place >= 0 && hold_place(&window_, place, options_.still_metres);
  monitor_.rho_sigma = held ? kHeldDistanceSigma<S> : kInverseDistanceSigma<S>;
  place_kept_ = held ? window_.n_poses - 3 - place : 0;
  statistics_.dropped_points += tracks_.observe(slot, points, n);
  const bool full = window_.n_poses == kWindow;
  const int used = full ? use_leaving_tracks(&window_, &tracks_, options_, &monitor_, &statistics_)
                        : use_ended_tracks(&window_, &tracks_, options_, &monitor_, &statistics_);
  if (used > 0) last_update_ = t_ns;
  if (full) make_room();
}

template <class S>
void Vio<S>::make_room() {
  tracks_.forget_slot(window_.pose[0].slot);
  drop_oldest(&window_);
}

/// Never diverge silently: what cannot be a device in someone's hand or on a robot is a lost filter.
template <class S>
bool Vio<S>::healthy() const {
  const State<S>& x = window_.now;
  const S speed2 = x.v_GI.squaredNorm(), place2 = x.p_GI.squaredNorm();
  if (!is_finite(speed2) || !is_finite(place2) || !is_finite(x.R_GI.sum())) return false;
  if (speed2 > options_.max_speed * options_.max_speed) return false;
  if (x.b_g.squaredNorm() > S(1) || x.b_a.squaredNorm() > S(9)) return false;
  if (S(time_ - last_update_) * S(1e-9) > options_.max_blind_s) return false;
  return denied_rest_ < kDeniedRest && !monitor_.failing();
}

template <class S>
VioStatus Vio<S>::give_up() {
  ++statistics_.restarts;
  origin_.remember(window_.now);
  window_.restore_calibration();
  forget();
  return VioStatus::lost;
}

}  // namespace SEGCAL_NS
