// A device: the stream of samples through the filter into segments, the database, and calibration (paper, Alg. 1).
// This is what the C API wraps; all memory is inside. What it does stands in device_stream.h (samples and frames),
// device_segments.h and device_calibration.h.
#pragma once

#include "api/release.h"
#include "api/result_hash.h"
#include "api/trigger.h"
#include "calibration/agreement.h"
#include "calibration/calibrator.h"
#include "database/database.h"
#include "diagnosis/effect_monitor.h"
#include "information/metrics.h"
#include "segments/boundary.h"
#include "segments/builder.h"
#include "vio/vio.h"

namespace SEGCAL_NS {

template <class S>
struct DeviceOptions {
  ThetaPrior<S> prior;          ///< its mean is the starting calibration
  S sigma_ref[kMaxTheta];
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
  bool has_temperature = false;
  std::uint32_t watch_effects = 0;  ///< bit e: the score test asks each scored segment about effect e
  bool joint_filter = false;    ///< the filter's own calibration is the result; no segments
  S outdated_level = S(1e-3);   ///< probability that a calibration drops segments although theta is the same; 0: never drops any
  bool calibrates_itself = true; ///< when it knows enough; else only where it is told to
};

/// Data faults, counted and survived.
struct FaultCounts {
  std::uint32_t imu_samples = 0, imu_stamps_back = 0, imu_gaps = 0, imu_not_finite = 0, imu_saturated = 0;
  std::uint32_t frames = 0, frames_used = 0, frame_stamps_back = 0, frames_dropped = 0, frames_few_tracks = 0;
  std::uint32_t points_not_finite = 0;
  std::uint32_t segments_closed = 0, segments_discarded = 0, segments_unsettled = 0, segments_outdated = 0;
  std::uint32_t segments_missed = 0;   ///< ended while a calibration was under way
  std::uint32_t slices_late = 0;       ///< done at once because the background had not come to them in time
  std::uint32_t calibrations = 0;
};

/// What became of a pushed sample or frame.
enum class Taken : std::int32_t { ok, waiting, skipped, tracking, lost, not_finite, stamp_back };

constexpr int kFewestTracks = 8;
constexpr int kOutdatedRounds = 2;
/// A calibration that the device began of its own takes effect at the fourth end of a segment after it (16 s): by then the
/// background has done its slices, and with a fixed time what comes out does not depend on when.
constexpr int kCalibrationWindow = 4;
constexpr int kMaxFramePoints = SEGCAL_MAX_TRACKS * kMaxCameras;

template <class S>
class Device {
 public:
  void create(const DeviceOptions<S>& options);

  Taken push_imu(std::int64_t t_ns, const InertialReading<S>& reading);
  /// degC, of the samples that follow.
  void set_temperature(S celsius) { imu_.set_warmth(celsius - S(25)); }
  Taken push_tracks(std::int64_t t_ns, const TrackPoint<S>* points, int n);
  Taken push_keyframe(std::int64_t t_ns, const State<S>& state, const TrackPoint<S>* points, int n);
  void flush();
  void new_session();
  /// At most `slices` pieces of pending work; returns 1 if some is left, else 0.
  int background(int slices);
  void calibrate();
  /// Rows [theta | candidates | rhs] of the kept slots in `use_slot`, in calibrator().theta_triangle() (Calibrator::rows_of).
  S linearise(const std::uint8_t* use_slot, const CandidateTerms& candidates);
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
  /// Over theta, its sigmas, all states so far and the kept segments (api/result_hash.h).
  std::uint64_t result_hash() const;
  EffectMonitor<S>& monitor() { return monitor_; }
  /// Of a watched effect; in the eliminator's memory.
  EffectScore<S> effect_score(int effect) {
    static_assert(ScoreTest<S>::scratch_size(kMaxEffectColumns) <= ReducedSystem<S>::kScratch, "the eliminator has too little to lend");
    return monitor_.score(effect, eliminator_.reduced().scratch());
  }
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
  const ThetaPrior<S>& prior() const { return options_.prior; }
  Taken process_frame();
  void count_missing_frames(std::int64_t t_ns);
  void take_keyframe(std::int64_t t_ns, const State<S>& state, const TrackPoint<S>* points, int n);
  void take_state(std::int64_t t_ns, const State<S>& state);
  bool keyframe_due(std::int64_t t_ns) const;
  bool segment_complete(std::int64_t t_ns, std::int64_t spacing);
  void break_stream();
  void end_segment(bool continues);
  Segment<S>& open_slot() { return scoring_ ? *spare_ : database_.building(); }
  void begin_score();
  bool score_step();
  void settle(const Segment<S>& segment);
  void end_score();
  void finish_score();
  bool knows_enough();
  void begin_calibration(const Calibration<S>& theta);
  bool calibrate_step();
  bool drop_outdated_step();
  bool drop_misfits_step();
  void begin_agreement();
  void finish_calibration();
  void take_release();
  bool step();
  void restart_filter();
  void start_clock(std::int64_t t_ns);
  void use_stamp_shift();
  /// A time offset moves the stamps of frames before filter and segments see them, in whole nanoseconds.
  static std::int32_t stamp_shift(const Calibration<S>& theta) {
    const S ns = theta.effects.value_of(kTimeOffsetTerm) * S(1e9);
    return static_cast<std::int32_t>(ns + (ns < S(0) ? S(-0.5) : S(0.5)));
  }
  void use_odometry(bool own);
  VioOptions<S> vio_options() const;
  void read_filter(Release<S>* out, InformationAnalysis<S>* analysis);
  Calibration<S> working_theta() const;
  /// Sums of information, in the eliminator's memory: what it holds is lost.
  JointInformation<S> joint_information() {
    static_assert(kJointScratch <= ReducedSystem<S>::kScratch, "the eliminator has too little to lend");
    return JointInformation<S>(prior().sigma, theta_.columns(), eliminator_.reduced().scratch());
  }

  DeviceOptions<S> options_;
  Calibration<S> theta_;   ///< best known: released, else the start
  ImuHistory<S> imu_;
  Vio<S> vio_;
  Database<S> database_;
  SegmentBuilder<S> builder_;
  Liveliness<S> liveliness_;
  SegmentEliminator<S> eliminator_;
  Calibrator<S> calibrator_;
  EffectMonitor<S> monitor_;
  InformationAnalysis<S> analysis_, joint_;
  Release<S> release_;
  FaultCounts faults_;
  State<S> state_;
  Hash trajectory_;   ///< of all states so far
  std::int64_t state_time_, last_imu_, last_frame_, pending_time_, next_keyframe_, frame_period_;
  TrackPoint<S> pending_[kMaxFramePoints];
  std::int32_t pending_count_;
  SegmentSummary<S> last_;
  std::uint32_t session_, serial_, frame_;
  std::int32_t thinned_;   ///< how often the open segment was
  std::int32_t stamp_shift_ns_;  ///< from stamps of frames to the IMU's clock, as known
  bool calibrated_, knew_enough_, own_odometry_;

  // Work in slices (math/resumable.h).
  bool scoring_;               ///< the slot being built holds a segment that waits for its score; the open one is in spare_
  bool calibrating_;
  std::int32_t window_;        ///< > 0: segment ends until a calibration takes effect
  Segment<S>* spare_;          ///< lent by the calibrator
  Calibration<S> known_theta_; ///< as known when the segment that is scored ended, or where the calibration under way began
  Place score_place_, calibrate_place_, inner_place_;
  LargestEigenvalue<S> largest_;
  Agreement<S> agreement_;
  Segment<S>* taking_part_[kMaxSegments];
  std::int32_t n_taking_part_, i_, round_;
  bool dropped_, settled_;
  JointInformation<S> sums_;
};

}  // namespace SEGCAL_NS

#include "api/device_calibration.h"
#include "api/device_segments.h"
#include "api/device_stream.h"
