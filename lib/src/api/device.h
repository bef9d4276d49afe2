// A device: the stream of samples through the filter into segments, the database, and calibration (paper, Alg. 1).
// This is what the C API wraps; all memory is inside. The policy of the stream stands here:
// what is a fault, when a segment ends, what a released calibration moves. It is in
// device_session.h (beginnings and ends), device_imu.h, device_stream.h (frames),
// device_segments.h and device_work.h; what is done with segments that have ended is in jobs.h.
#pragma once

#include "api/jobs.h"
#include "api/result_hash.h"
#include "api/streams.h"

namespace SEGCAL_NS {

/// What became of a pushed sample or frame.
enum class Taken : std::int32_t { ok, waiting, skipped, tracking, lost, not_finite, stamp_refused };

/// A frame with fewer points tells hardly anything of the motion.
constexpr int kFewestTracks = 8;

template <class S>
class Device {
  friend struct StoredFields<S>;

 public:
  [[gnu::cold]] Device() = default;
  [[gnu::cold]] void create(const DeviceOptions<S>& options, ColdParts<S>* cold);
  /// After its memory was moved as bytes: where the cold parts are now. False, and nothing has changed, if they have
  /// moved by another distance than the rest while work is pending.
  [[gnu::cold]] bool attach(ColdParts<S>* cold);
  const ColdParts<S>* cold() const { return d_.cold; }

  /// `celsius`: of this sample and those that follow; not-a-number: as before.
  Taken push_imu(std::int64_t t_ns, const InertialReading<S>& reading, S celsius);
  /// `point(i)`: point i of n, a TrackPoint<S>.
  template <class Point>
  Taken push_tracks(std::int64_t t_ns, int n, Point point);
  /// `p_GI`: of the state, m, in the user's frame; that of `state` is not read.
  template <class Point>
  Taken push_keyframe(std::int64_t t_ns, const State<S>& state, const double* p_GI, int n, Point point);
  void flush();
  /// One slice of flush(); false when nothing is left.
  bool flush_step();
  void new_session();
  /// At most `slices` slices of pending work; returns 1 if some is left, else 0.
  int background(int slices);
  void calibrate();
  /// The same in slices: after the next segment that is scored, or by flush_step().
  void request_calibration() { jobs_.request(); }
  /// Work that is due is done in the call that feeds, where it was not done before.
  /// Else, as from create() on, no call that feeds does it: a segment that ends while
  /// the one before is scored is dropped, a calibration and a start are waited for.
  void work_when_due(bool on) {
    at_once_ = on;
    odometry_.filter.finish_late_starts(on);
  }
  /// Rows [theta | candidates | rhs] of the kept slots in `use_slot`, in calibrator().theta_triangle()
  /// (Calibrator::rows_of). Only while nothing is pending.
  [[gnu::cold]] S linearise(const std::uint8_t* use_slot, const CandidateTerms& candidates);
  /// The filter's own calibration at this moment, judged as a result.
  void read_filter(Release<S>* out) { read_filter(out, nullptr); }

  const State<S>& state() const { return odometry_.state; }
  /// What state().p_GI counts from, m.
  const double* origin() const { return odometry_.origin; }
  std::int64_t state_time() const { return odometry_.state_ns; }
  bool has_state() const { return odometry_.has_state; }
  const Calibration<S>& theta() const { return theta_; }
  const DeviceOptions<S>& options() const { return d_.options; }
  /// Where residuals of the kept segments are to be taken: where the last fit ended that took effect. Before, where the
  /// device started, and they tell nothing.
  const Calibration<S>& fitted_theta() const { return has_report() ? report().theta : theta_; }
  /// As published by the last calibration that took effect.
  const CalibrationReport<S>& report() const { return jobs_.report(); }
  bool has_report() const { return jobs_.has_report(); }
  const ScoreReport<S>& last_scored() const { return jobs_.last_scored(); }
  Calibrator<S>& calibrator() { return d_.calibrator(); }
  const Calibrator<S>& calibrator() const { return d_.calibrator(); }
  const Database<S>& database() const { return d_.database(); }
  const auto& epochs() const { return d_.epochs; }
  const auto& changes() const { return d_.changes; }
  const auto& history() const { return d_.history; }
  /// None is being added to, compared or moved.
  bool epochs_at_rest() const { return !pending(); }
  /// The right to work in the shared memory, to answer a question while nothing is pending.
  void begin_question(typename Workspace<S>::Lease* lease) { d_.work.begin_lease(WorkOwner::question, lease); }
  /// A score or a calibration is under way, or a calibration waits for its moment.
  bool pending() const { return jobs_.pending(); }
  /// The kept segments are as a calibration or their builder left them, not half moved.
  bool segments_at_rest() const { return !jobs_.calibration_pending(); }
  /// Over theta, its sigmas and all states so far; and the kept segments once everything that was pending has been
  /// finished by flush(), new_session() or calibrate() (api/result_hash.h).
  [[gnu::cold]] std::uint64_t result_hash() const;
  bool start_pending() const { return odometry_.filter.start_pending(); }
  bool scoring() const { return jobs_.scoring(); }
  bool calibrating() const { return jobs_.calibrating(); }
  /// Ends of segments until the calibration under way takes effect, if it is done by then.
  int ends_left() const { return jobs_.ends_left(); }
  const SliceCounts& slices() const { return d_.slices; }
  EffectMonitor<S>& monitor() { return d_.monitor; }
  const FaultCounts& faults() const { return d_.faults; }
  /// The caller's odometry, or the filter at this moment.
  bool odometry_runs() const { return odometry_.runs(); }
  /// What had come when the odometry used a frame with enough points the last time.
  const StreamCounts& counts_at_last_use() const { return frames_.at_last_use; }
  const VioStatistics& vio_statistics() const { return odometry_.filter.statistics(); }
  const ImuHistory<S>& imu_history() const { return imu_.history; }
  /// IMU readings that stood alone, since create().
  std::uint32_t imu_spikes() const { return imu_.spikes_found; }
  /// Frames that found no place to wait for their IMU samples.
  std::uint32_t frames_crowded_out() const { return frames_.crowded_out; }
  /// s between the frames that the odometry is offered: the camera's period, or frame_interval_s where that is longer.
  S frame_distance_s() const {
    const S period = S(frames_.period_ns) * S(1e-9);
    return period > d_.options.frame_interval_s ? period : d_.options.frame_interval_s;
  }
  const BuilderCounts& builder_counts() const { return d_.builder.counts(); }
  static constexpr std::size_t workspace_bytes() {
    return sizeof(Workspace<S>) + sizeof(Calibrator<S>) + 2 * sizeof(Directions<S>);
  }

 private:
  const ThetaPrior<S>& prior() const { return d_.options.prior; }
  SegmentBuilder<S>& builder() { return d_.builder; }

  // device_session.h
  [[gnu::cold]] void restart_filter();
  [[gnu::cold]] void begin_session();
  [[gnu::cold]] VioOptions<S> vio_options() const;

  // device_imu.h
  static bool in_range(const Vec3<S>& reading, S range) { return reading.cwiseAbs().maxCoeff() < range; }
  void keep_unbroken(std::int64_t t_ns, const InertialReading<S>& reading);
  [[gnu::cold]] bool bridge_is_short(std::int64_t t_ns, int wrong) const;
  void break_stream();
  void start_clock(std::int64_t t_ns);

  // device_stream.h
  bool take_frame_stamp(std::int64_t t_ns);
  void forget_frames();
  template <class Point>
  bool let_wait(std::int64_t t_ns, std::int32_t shift_ns, int n, Point point);
  Taken process_frames();
  Taken process_frame();
  Taken track(const Frame<S>& frame);
  [[gnu::cold]] Taken take_own_keyframe(const Frame<S>& frame);
  bool frame_ready() {
    return !frames_.waiting.empty() && imu_.history.size() > 1 &&
           imu_.history.newest() >= frames_.waiting.front().time_ns();
  }
  void count_missing_frames(std::int64_t t_ns);
  void take_state(std::int64_t t_ns, const State<S>& state);
  void keep_near_origin();
  void use_odometry(bool own);

  // device_segments.h
  [[gnu::cold]] void take_keyframe(const Frame<S>& frame, const State<S>& state);
  bool keyframe_due(std::int64_t t_ns) const;
  bool segment_complete(std::int64_t t_ns, std::int64_t spacing);
  void end_segment(bool continues);
  void begin_segment(bool continues);
  [[gnu::cold]] void hand_over();
  Segment<S>& open_slot() { return jobs_.open_slot(&d_); }
  Calibration<S> working_theta() const;

  // device_work.h
  [[gnu::noinline]] bool step();
  [[gnu::cold]] void finish_start();
  [[gnu::cold]] void calibrate_as_wanted();
  [[gnu::cold]] void publish_calibration();
  void finish_calibration();
  [[gnu::cold]] void take_release();
  [[gnu::cold]] void give_filter_calibration();
  [[gnu::cold]] void read_filter(Release<S>* out, InformationAnalysis<S>* analysis);
  /// A time offset moves the stamps of frames before filter and segments see them, in whole nanoseconds.
  static std::int32_t stamp_shift(const Calibration<S>& theta) {
    const S limit = S(1e9);  // 1 s: far beyond what the filter could bridge; and inside 32 bits
    const S ns = theta.effects.value_of(kTimeOffsetTerm) * S(1e9);
    return static_cast<std::int32_t>(ns < -limit ? -limit : ns > limit ? limit : ns + (ns < S(0) ? S(-0.5) : S(0.5)));
  }

  DeviceParts<S> d_;
  Calibration<S> theta_;  ///< best known: released, else the start
  Jobs<S> jobs_;
  ImuStream<S> imu_;
  FrameStream<S> frames_;
  Odometry<S> odometry_;
  KeyframeGrid<S> grid_;
  std::uint32_t session_, serial_;
  std::int32_t stamp_shift_ns_;  ///< from stamps of frames to the IMU's clock: for frames that come from now on
  bool at_once_;                 ///< work that is due is done by the call that feeds
};

}  // namespace SEGCAL_NS

#include "api/device_imu.h"
#include "api/device_segments.h"
#include "api/device_session.h"
#include "api/device_stream.h"
#include "api/device_work.h"
