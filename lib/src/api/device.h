// A device: the stream of samples through the filter into segments, the database, and calibration (paper, Alg. 1).
// This is what the C API wraps; all memory is inside.
#pragma once

#include "api/release.h"
#include "api/trigger.h"
#include "calibration/agreement.h"
#include "calibration/calibrator.h"
#include "database/database.h"
#include "information/metrics.h"
#include "segments/boundary.h"
#include "segments/builder.h"
#include "vio/vio.h"

namespace SEGCAL_NS {

template <class S>
struct DeviceOptions {
  Calibration<S> theta;         ///< starting calibration, mean of the prior
  S prior_sigma[kMaxTheta], sigma_ref[kMaxTheta];
  S target_sigma[kMaxTheta];    ///< calibration starts when the kept segments predict these; all 0: when the database is full
  MeasurementModel<S> model;
  S imu_rate_hz = S(200), gyro_range = S(35), accel_range = S(157);
  S frame_interval_s = S(0.1), segment_s = S(4);
  S filter_share = S(1);        ///< on the sigmas of the filter's own estimates of the calibration
  S least_segment_s = S(0), most_segment_s = S(0);   ///< bounds of segments of open length; both 0: all of segment_s
  int keep_segments = 8;
  Metric metric = Metric::A;
  Strategy strategy = Strategy::single_session;
  S least_gain = S(14);
  std::uint64_t seed = 0;
  bool joint_filter = false;    ///< the filter's own calibration is the result; no segments
  S outdated_level = S(1e-3);   ///< probability that a calibration drops segments although theta is the same; 0: never drops any
};

/// Data faults, counted and survived.
struct FaultCounts {
  std::uint32_t imu_samples = 0, imu_stamps_back = 0, imu_gaps = 0, imu_not_finite = 0, imu_saturated = 0;
  std::uint32_t frames = 0, frames_used = 0, frame_stamps_back = 0, frames_dropped = 0, frames_few_tracks = 0;
  std::uint32_t points_not_finite = 0;
  std::uint32_t segments_closed = 0, segments_discarded = 0, segments_unsettled = 0, segments_outdated = 0;
};

/// What became of a pushed sample or frame.
enum class Taken : std::int32_t { ok, waiting, skipped, tracking, lost, not_finite, stamp_back };

constexpr int kFewestTracks = 8;
constexpr int kOutdatedRounds = 2;
constexpr int kMaxFramePoints = SEGCAL_MAX_TRACKS * kMaxCameras;

template <class S>
class Device {
 public:
  void create(const DeviceOptions<S>& options);

  Taken push_imu(std::int64_t t_ns, const InertialReading<S>& reading);
  Taken push_tracks(std::int64_t t_ns, const TrackPoint<S>* points, int n);
  Taken push_keyframe(std::int64_t t_ns, const State<S>& state, const TrackPoint<S>* points, int n);
  void flush();
  void new_session();
  int background(int slices);
  void calibrate();
  /// The filter's own calibration at this moment, judged as a result.
  void read_filter(Release<S>* out) { read_filter(out, nullptr); }

  const State<S>& state() const { return state_; }
  std::int64_t state_time() const { return state_time_; }
  bool has_state() const { return state_time_ != kNever; }
  const Calibration<S>& theta() const { return theta_; }
  const DeviceOptions<S>& options() const { return options_; }
  const Release<S>& release() const { return release_; }
  bool has_release() const { return calibrated_; }
  Calibrator<S>& calibrator() { return calibrator_; }
  const Calibrator<S>& calibrator() const { return calibrator_; }
  Database<S>& database() { return database_; }
  const Database<S>& database() const { return database_; }
  const FaultCounts& faults() const { return faults_; }
  const VioStatistics& vio_statistics() const { return vio_.statistics(); }
  const BuilderCounts& builder_counts() const { return builder_.counts(); }
  const InformationAnalysis<S>& analysis() const { return analysis_; }
  /// What was said about the segment scored last; its slot may already hold the next one.
  const SegmentSummary<S>& last_scored() const { return last_; }
  /// Directions over all kept segments after calibrate().
  const InformationAnalysis<S>& joint_analysis() const { return joint_; }
  static constexpr std::size_t workspace_bytes() {
    return sizeof(SegmentEliminator<S>) + sizeof(Calibrator<S>) + 2 * sizeof(InformationAnalysis<S>);
  }

 private:
  static constexpr std::int64_t kNever = INT64_MIN;
  Taken process_frame();
  void count_missing_frames(std::int64_t t_ns);
  void take_keyframe(std::int64_t t_ns, const State<S>& state, const TrackPoint<S>* points, int n);
  bool keyframe_due(std::int64_t t_ns) const;
  bool segment_complete(std::int64_t t_ns, std::int64_t spacing);
  void break_stream();
  void end_segment(bool continues);
  void score();
  bool knows_enough();
  void fit();
  bool drop_outdated();
  void drop_misfits();
  void restart_filter();
  void use_odometry(bool own);
  VioOptions<S> vio_options() const;
  void read_filter(Release<S>* out, InformationAnalysis<S>* analysis);
  Calibration<S> working_theta() const;
  /// Sums of information, in the eliminator's memory: what it holds is lost.
  JointInformation<S> joint_information() {
    static_assert(kJointScratch <= ReducedSystem<S>::kScratch, "the eliminator has too little to lend");
    return JointInformation<S>(prior_.sigma, theta_.columns(), eliminator_.reduced().scratch());
  }

  DeviceOptions<S> options_;
  Calibration<S> theta_;   ///< best known: released, else the start
  ThetaPrior<S> prior_;
  ImuHistory<S> imu_;
  Vio<S> vio_;
  Database<S> database_;
  SegmentBuilder<S> builder_;
  Liveliness<S> liveliness_;
  SegmentEliminator<S> eliminator_;
  Calibrator<S> calibrator_;
  InformationAnalysis<S> analysis_, joint_;
  Release<S> release_;
  FaultCounts faults_;
  State<S> state_;
  std::int64_t state_time_, last_imu_, last_frame_, pending_time_, next_keyframe_, frame_period_;
  TrackPoint<S> pending_[kMaxFramePoints];
  std::int32_t pending_count_;
  SegmentSummary<S> last_;
  std::uint32_t session_, serial_, frame_;
  std::int32_t thinned_;   ///< how often the open segment was
  bool calibrated_, calibration_due_, knew_enough_, own_odometry_;
};

template <class S>
void Device<S>::create(const DeviceOptions<S>& options) {
  options_ = options;
  theta_ = options.theta;
  prior_.mean = options.theta;
  for (int i = 0; i < kMaxTheta; ++i) prior_.sigma[i] = options.prior_sigma[i];
  database_.reset(options.keep_segments, options.metric, options.strategy, options.least_gain, options.seed);
  builder_.reset(options.gyro_range, options.accel_range);
  faults_ = FaultCounts{};
  release_ = Release<S>{};
  joint_.n = analysis_.n = 0;
  frame_period_ = 0;
  session_ = serial_ = frame_ = 0;
  thinned_ = 0;
  liveliness_.reset();
  last_ = SegmentSummary<S>{};
  calibrated_ = calibration_due_ = knew_enough_ = own_odometry_ = false;
  vio_.reset(theta_, vio_options());
  restart_filter();
}

/// The filter states its own calibration only where that is asked for; then it starts from the device's prior.
template <class S>
VioOptions<S> Device<S>::vio_options() const {
  VioOptions<S> vio;
  vio.noise = options_.model.imu;
  vio.g = options_.model.g;
  vio.frame_interval_s = options_.frame_interval_s;
  vio.share_calibration(options_.filter_share);
  if (!options_.joint_filter) return vio;
  const S* sigma = options_.prior_sigma;
  const S* imu_sigma = sigma + options_.theta.imu_column();
  vio.pixel_sigma = options_.model.pixel_sigma;
  vio.sigma_r_CI = sigma[0];
  vio.sigma_p_CI = sigma[3];
  vio.sigma_focal = sigma[6] / options_.theta.camera[0].intrinsics(0);
  vio.sigma_centre = sigma[8];
  vio.sigma_distortion = sigma[10];
  vio.sigma_gyro = imu_sigma[0];
  vio.sigma_accel = imu_sigma[6];
  vio.sigma_r_AI = imu_sigma[12];
  return vio;
}

/// Everything that belongs to one unbroken stretch of data starts anew.
template <class S>
void Device<S>::restart_filter() {
  imu_.clear();
  if (options_.joint_filter && vio_.knows_sensors()) {
    vio_.next_session();
  } else {
    vio_.reset(theta_, vio_options());
  }
  if (!options_.joint_filter && calibrated_ && release_.status != Status::failed) vio_.set_calibration(theta_);
  if (!own_odometry_) ++frame_;
  builder_.begin(&database_.building(), session_, serial_, false);
  state_time_ = last_imu_ = last_frame_ = pending_time_ = next_keyframe_ = kNever;
  pending_count_ = 0;
}

/// Where states come from. Two sources have two frames; the user's own frame outlives gaps in the IMU's stream.
template <class S>
void Device<S>::use_odometry(bool own) {
  if (own == own_odometry_) return;
  if (!builder_.empty()) end_segment(false);
  own_odometry_ = own;
  ++frame_;
}

/// theta for triangulation and scoring: the extrinsics are the filter's (paper, Sec. IV-B).
template <class S>
Calibration<S> Device<S>::working_theta() const {
  Calibration<S> theta = theta_;
  if (own_odometry_ || !vio_.initialised()) return theta;
  for (int c = 0; c < theta.n_cameras; ++c) {
    theta.camera[c].R_CI = vio_.R_CI(c);
    theta.camera[c].p_CI = vio_.p_CI(c);
  }
  return theta;
}

template <class S>
Taken Device<S>::push_imu(std::int64_t t_ns, const InertialReading<S>& reading) {
  ++faults_.imu_samples;
  if (!is_finite(reading.gyro.sum()) || !is_finite(reading.accel.sum())) {
    ++faults_.imu_not_finite;
    return Taken::not_finite;
  }
  if (last_imu_ != kNever && t_ns <= last_imu_) {
    ++faults_.imu_stamps_back;
    return Taken::stamp_back;
  }
  for (int i = 0; i < 3; ++i) {
    if (absolute(reading.gyro(i)) < options_.gyro_range && absolute(reading.accel(i)) < options_.accel_range) continue;
    ++faults_.imu_saturated;
    break;
  }
  if (last_imu_ != kNever && S(t_ns - last_imu_) * S(1e-9) > S(3) / options_.imu_rate_hz) {
    ++faults_.imu_gaps;
    break_stream();
  }
  last_imu_ = t_ns;
  imu_.push(t_ns, reading);
  return pending_count_ > 0 && imu_.newest() >= pending_time_ ? process_frame() : Taken::ok;
}

/// A gap: the open segment ends with what it has, the filter starts again.
template <class S>
void Device<S>::break_stream() {
  const std::int64_t last_frame = last_frame_;
  end_segment(false);
  restart_filter();
  last_frame_ = last_frame;
}

/// Frames missing from an even stream: the shortest interval seen so far is the camera's period.
template <class S>
void Device<S>::count_missing_frames(std::int64_t t_ns) {
  if (last_frame_ == kNever) return;
  const std::int64_t interval = t_ns - last_frame_;
  if (frame_period_ == 0 || interval < frame_period_) frame_period_ = interval;
  const std::int64_t periods = (interval + frame_period_ / 2) / frame_period_;
  if (periods > 1) faults_.frames_dropped += static_cast<std::uint32_t>(periods - 1);
}

template <class S>
Taken Device<S>::push_tracks(std::int64_t t_ns, const TrackPoint<S>* points, int n) {
  ++faults_.frames;
  if (last_frame_ != kNever && t_ns <= last_frame_) {
    ++faults_.frame_stamps_back;
    return Taken::stamp_back;
  }
  if (pending_count_ > 0) ++faults_.frames_dropped;  // its IMU samples never came
  count_missing_frames(t_ns);
  last_frame_ = t_ns;
  pending_time_ = t_ns;
  pending_count_ = 0;
  for (int i = 0; i < n && pending_count_ < kMaxFramePoints; ++i) {
    if (is_finite(points[i].uv.x()) && is_finite(points[i].uv.y())) {
      pending_[pending_count_++] = points[i];
    } else {
      ++faults_.points_not_finite;
    }
  }
  if (pending_count_ < kFewestTracks) ++faults_.frames_few_tracks;
  if (imu_.size() < 2 || imu_.newest() < t_ns) return Taken::waiting;
  return process_frame();
}

template <class S>
Taken Device<S>::process_frame() {
  const int n = pending_count_;
  pending_count_ = 0;
  if (imu_.oldest() > pending_time_) return Taken::waiting;
  use_odometry(false);
  switch (vio_.push_frame(pending_time_, pending_, n, imu_)) {
    case VioStatus::skipped: return Taken::skipped;
    case VioStatus::lost:
      end_segment(false);
      ++frame_;
      state_time_ = kNever;
      return Taken::lost;
    case VioStatus::tracking: break;
    default: return Taken::waiting;
  }
  ++faults_.frames_used;
  state_ = vio_.state();
  state_time_ = vio_.time();
  if (!options_.joint_filter && keyframe_due(state_time_)) take_keyframe(state_time_, state_, pending_, n);
  return Taken::tracking;
}

template <class S>
Taken Device<S>::push_keyframe(std::int64_t t_ns, const State<S>& state, const TrackPoint<S>* points, int n) {
  ++faults_.frames;
  if (last_frame_ != kNever && t_ns <= last_frame_) {
    ++faults_.frame_stamps_back;
    return Taken::stamp_back;
  }
  if (!imu_.covers(t_ns, t_ns)) return Taken::waiting;
  last_frame_ = t_ns;
  use_odometry(true);
  ++faults_.frames_used;
  state_ = state;
  state_time_ = t_ns;
  take_keyframe(t_ns, state, points, n);
  return Taken::tracking;
}

/// Keyframes stand on a grid of segment_s / keyframes, so that their mean spacing is that whatever the frame rate.
template <class S>
bool Device<S>::keyframe_due(std::int64_t t_ns) const {
  const std::int64_t half_frame = static_cast<std::int64_t>(options_.frame_interval_s * S(0.5e9));
  return next_keyframe_ == kNever || t_ns + half_frame >= next_keyframe_;
}

/// True if the open segment ends before a keyframe at t_ns.
template <class S>
bool Device<S>::segment_complete(std::int64_t t_ns, std::int64_t spacing) {
  const std::int64_t length_ns = t_ns - builder_.start_ns() + spacing / 2;
  if (!(options_.most_segment_s > S(0))) return length_ns >= std::int64_t(options_.segment_s * S(1e9));
  const std::int64_t from = builder_.last_keyframe_ns();
  if (imu_.covers(from, t_ns)) liveliness_.add(imu_, from, t_ns);
  return ends_here(liveliness_, S(length_ns) * S(1e-9), options_.segment_s, options_.least_segment_s, options_.most_segment_s);
}

template <class S>
void Device<S>::take_keyframe(std::int64_t t_ns, const State<S>& state, const TrackPoint<S>* points, int n) {
  const std::int64_t base = static_cast<std::int64_t>(options_.segment_s * S(1e9)) / kMaxKeyframes;
  const bool late = next_keyframe_ != kNever && t_ns > next_keyframe_ + 4 * (base << thinned_);
  if (late) end_segment(false);
  if (!builder_.empty() && segment_complete(t_ns, base << thinned_)) end_segment(true);
  if (builder_.full() && options_.most_segment_s > options_.segment_s) {
    builder_.thin();
    ++thinned_;
  }
  next_keyframe_ = (next_keyframe_ == kNever || late ? t_ns : next_keyframe_) + (base << thinned_);
  if (builder_.add_keyframe(t_ns, state, points, n, imu_)) return;
  end_segment(true);
  builder_.add_keyframe(t_ns, state, points, n, imu_);
}

/// Closes, scores and offers the open segment, then opens the next one.
template <class S>
void Device<S>::end_segment(bool continues) {
  if (!builder_.empty()) {
    ++faults_.segments_closed;
    database_.building().frame = frame_;
    if (builder_.close(working_theta(), options_.model)) {
      score();
    } else {
      ++faults_.segments_discarded;
    }
  }
  ++serial_;
  thinned_ = 0;
  builder_.begin(&database_.building(), session_, serial_, continues);
}

template <class S>
void Device<S>::score() {
  Segment<S>& segment = database_.building();
  GuestLink<S> alone;
  const Calibration<S> theta = working_theta();
  segment.turned_only = segment.wide_depth_prior = !translation_shows(segment, theta, options_.model);
  eliminator_.eliminate(segment, alone, theta, options_.model, S(0));
  eliminator_.extract(&segment.information);
  analyse(segment.information, prior_.sigma, &analysis_);
  segment.metrics = metrics_of(&analysis_, prior_.sigma, options_.sigma_ref);
  last_ = summary_of(segment);
  const bool settled = follows_its_imu(segment, theta, options_.model);
  if (!settled) ++faults_.segments_unsettled;
  JointInformation<S> joint = joint_information();
  last_.kept = settled && database_.offer(&joint);
  if (last_.kept && !knew_enough_ && knows_enough()) {
    knew_enough_ = true;
    calibration_due_ = true;
  }
}

/// True if the kept segments are worth a calibration: there are enough (paper, Alg. 1), or, where there are targets, they
/// predict that these will be reached.
template <class S>
bool Device<S>::knows_enough() {
  if (!has_targets(options_.target_sigma, theta_.columns())) return database_.full();
  const SegmentInformation<S>* segments[kMaxSegments];
  int n = 0;
  for (int i = 0; i < Database<S>::kSlots; ++i) {
    if (database_.kept(i)) segments[n++] = &database_.slot(i).information;
  }
  JointInformation<S> joint = joint_information();
  return reaches_targets(joint.sum(segments, n), prior_.sigma, options_.target_sigma, database_.full());
}

template <class S>
void Device<S>::flush() {
  if (pending_count_ > 0 && imu_.covers(pending_time_, pending_time_)) process_frame();
  end_segment(false);
  next_keyframe_ = kNever;
}

template <class S>
void Device<S>::new_session() {
  flush();
  ++session_;
  ++frame_;
  knew_enough_ = false;
  database_.begin_session();
  restart_filter();
}

template <class S>
int Device<S>::background(int slices) {
  if (slices > 0 && calibration_due_) calibrate();
  return calibration_due_ ? 1 : 0;
}

template <class S>
void Device<S>::read_filter(Release<S>* out, InformationAnalysis<S>* analysis) {
  if (!vio_.knows_sensors()) return release_prior(prior_, out);
  const Calibration<S>& theta = vio_.calibration();
  PackedTriangle<S> R(analysis_.W, theta.columns() + 1);  // free between two scores
  vio_.calibration_information(&R);
  if (analysis) analyse_with_prior(R, prior_.sigma, analysis);
  judge_filter(theta, prior_, ReleaseRules<S>{}, &R, out);
}

template <class S>
void Device<S>::calibrate() {
  calibration_due_ = false;
  if (options_.joint_filter) {
    read_filter(&release_, &joint_);
    calibrated_ = true;
    theta_ = release_.theta;
    return;
  }
  fit();
  // Without the outdated ones theta is another, and there may be more that do not agree with that.
  for (int round = 0; round < kOutdatedRounds && drop_outdated(); ++round) fit();
  analyse_with_prior(calibrator_.theta_triangle(), prior_.sigma, &joint_);
  judge(&calibrator_, prior_, ReleaseRules<S>{}, &release_);
  calibrated_ = true;
  if (release_.status == Status::failed) {
    drop_misfits();
    return;
  }
  theta_ = release_.theta;
  if (vio_.initialised()) vio_.set_calibration(theta_);
}

template <class S>
void Device<S>::fit() {
  Segment<S>* segments[kMaxSegments];
  const int count = database_.in_order(segments);
  calibrator_.begin(segments, count, prior_, working_theta(), options_.model);
  calibrator_.accept_all();
  CalibratorOptions rough;
  rough.converged = rough.settled = 0.1;
  calibrator_.run(rough, &eliminator_);
  // Corners that are still far off once the model fits are no noise: they are left out, and the rest fits again.
  calibrator_.reject_outliers(S(5));
  calibrator_.run(CalibratorOptions{}, &eliminator_);
}

/// Drops segments that newer ones contradict (calibration/agreement.h); true if there were any. All are scored again at
/// the calibrated theta, each alone: what a segment says must not come from its neighbours.
template <class S>
bool Device<S>::drop_outdated() {
  Segment<S>* segments[kMaxSegments];
  const SegmentInformation<S>* information[kMaxSegments];
  const int count = database_.in_order(segments);
  if (count < 3 || !calibrator_.fit().converged || !(options_.outdated_level > S(0))) return false;
  for (int i = 0; i < count; ++i) {
    eliminator_.eliminate(*segments[i], GuestLink<S>{}, calibrator_.theta(), options_.model, S(0));
    eliminator_.extract(&segments[i]->information);
    information[i] = &segments[i]->information;
  }
  static_assert(Agreement<S>::kScratch <= ReducedSystem<S>::kScratch, "the eliminator has too little to lend");
  Agreement<S> newer(prior_, calibrator_.theta(), options_.outdated_level / S(count - 1), noise_of(information, count), &joint_,
                     eliminator_.reduced().scratch());
  const std::uint32_t before = faults_.segments_outdated;
  for (int i = count - 1; i >= 0; --i) {
    if (!newer.outdated(*information[i])) continue;
    database_.drop_outdated(segments[i]);
    ++faults_.segments_outdated;
  }
  if (faults_.segments_outdated == before) return false;
  knew_enough_ = knew_enough_ && knows_enough();
  return true;
}

/// After a failed calibration: segments that do not fit even alone leave the database, and collecting goes on.
template <class S>
void Device<S>::drop_misfits() {
  for (int i = 0; i < Database<S>::kSlots; ++i) {
    if (!database_.kept(i)) continue;
    const Segment<S>& segment = database_.slot(i);
    const S cost = segment_cost(segment, GuestLink<S>{}, calibrator_.theta(), options_.model);
    if (cost <= ReleaseRules<S>{}.most_chi2_per_dof * S(segment.information.dof)) continue;
    database_.drop(i);
    ++faults_.segments_unsettled;
  }
  knew_enough_ = knew_enough_ && knows_enough();
}

}  // namespace SEGCAL_NS
