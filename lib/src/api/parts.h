// What a device is made of, as its jobs (score_job.h, calibrate_job.h) see it; its options and the faults that it
// counts.
#pragma once

#include "api/release.h"
#include "api/workspace.h"
#include "calibration/changes.h"
#include "calibration/condenser.h"
#include "database/database.h"
#include "diagnosis/effect_monitor.h"
#include "segments/builder.h"

namespace SEGCAL_NS {

template <class S>
struct DeviceOptions {
  ThetaPrior<S> prior;  ///< its mean is the starting calibration
  S sigma_ref[kMaxTheta] = {};
  S target_sigma[kMaxTheta] =
      {};  ///< calibration starts when the kept segments predict these; all 0: when the database is full
  MeasurementModel<S> model;
  S imu_rate_hz = S(200), gyro_range = S(35), accel_range = S(157);
  std::int32_t imu_group = 1;  ///< samples that become one (sensors/decimation.h)
  S frame_interval_s = S(0.1), segment_s = S(4);
  S filter_share = S(1);                            ///< on the sigmas of the filter's own estimates of the calibration
  S least_segment_s = S(0), most_segment_s = S(0);  ///< bounds of segments of open length; both 0: all of segment_s
  int keep_segments = 8;
  Metric metric = Metric::A;
  Strategy strategy = Strategy::single_session;
  S least_gain = S(14);
  std::uint64_t seed = 0;
  bool has_temperature = false;
  std::uint32_t watch_effects = 0;  ///< bit e: the score test asks each scored segment about effect e
  bool joint_filter = false;        ///< the filter's own calibration is the result; no segments
  S outdated_level =
      S(1e-3);  ///< probability that a calibration drops segments although theta is the same; 0: never drops any
  bool condense = false;          ///< segments that end once theta was released go into epochs, not into the database
  bool calibrates_itself = true;  ///< when it knows enough; else only where it is told to
  std::int32_t calibration_window = 4;  ///< ends of segments from its beginning until it takes effect
};

/// Data faults, counted and survived.
struct FaultCounts {
  std::uint32_t imu_samples = 0, imu_stamps_back = 0, imu_gaps = 0, imu_not_finite = 0, imu_saturated = 0;
  std::uint32_t frames = 0, frames_used = 0, frame_stamps_back = 0, frames_dropped = 0, frames_few_tracks = 0;
  std::uint32_t points_not_finite = 0, points_repeated = 0;
  std::uint32_t imu_stamps_far = 0,
                frame_stamps_far = 0;  ///< refused: no neighbour of the stamps before, or of the other sensor's
  std::uint32_t clock_restarts = 0;    ///< the IMU's clock jumped for good: the stream began anew
  std::uint32_t segments_closed = 0, segments_discarded = 0, segments_unsettled = 0, segments_outdated = 0;
  std::uint32_t segments_missed = 0;  ///< ended while a calibration was under way
  std::uint32_t slices_late = 0;      ///< work was due that the background had not done: dropped or put off
  std::uint32_t calibrations = 0, calibrations_published = 0;  ///< begun; taken effect
  std::uint32_t segments_late = 0;                             ///< ended while the one before was still being scored
};

/// Background work in slices.
struct SliceCounts {
  std::uint32_t all = 0;                     ///< done since create()
  std::uint32_t job = 0;                     ///< of them, by the score or calibration under way
  std::uint32_t score = 0, calibration = 0;  ///< that the last one took

  void begin_job() { job = 0; }
  void count() {
    ++all;
    ++job;
  }
};

/// Of the samples and frames that came, those that were refused, that are at full scale or come after a gap, and frames
/// with few points.
struct StreamCounts {
  std::uint32_t imu = 0, imu_refused = 0, imu_saturated = 0, imu_gaps = 0, frames = 0, frames_far = 0, frames_back = 0,
                frames_few = 0;

  StreamCounts() = default;
  explicit StreamCounts(const FaultCounts& f)
      : imu(f.imu_samples),
        imu_refused(f.imu_stamps_back + f.imu_stamps_far + f.imu_not_finite),
        imu_saturated(f.imu_saturated),
        imu_gaps(f.imu_gaps),
        frames(f.frames),
        frames_far(f.frame_stamps_far),
        frames_back(f.frame_stamps_back),
        frames_few(f.frames_few_tracks) {}
};

/// What the stream touches little: segments, the open one too, and what a calibration from them needs. It may lie in a
/// block of memory of its own.
template <class S>
struct ColdParts {
  [[gnu::cold]] ColdParts() = default;

  Database<S> database;
  Calibrator<S> calibrator;
};

template <class S>
struct DeviceParts {
  [[gnu::cold]] DeviceParts() = default;

  Near<ColdParts<S>> cold;
  Database<S>& database() const { return cold->database; }
  Calibrator<S>& calibrator() const { return cold->calibrator; }

  DeviceOptions<S> options;
  SegmentBuilder<S> builder;
  Workspace<S> work;
  EffectMonitor<S> monitor;
  std::conditional_t<(kEpochs > 0), Epochs<S>, NoEpochs<S>> epochs;
  std::conditional_t<(kEpochs > 0), Condenser<S>, NoCondenser> condenser;
  std::conditional_t<(kEpochs > 0), Changes<S>, NoChanges<S>> changes;
  FaultCounts faults;
  SliceCounts slices;

  const ThetaPrior<S>& prior() const { return options.prior; }
};

/// Triangle of the prior and the kept segments, each alone, in units of the prior's sigmas. In the workspace.
template <class S>
PackedTriangle<S> sum_of_kept(DeviceParts<S>* d) {
  const SegmentInformation<S>* segments[kMaxSegments];
  int n = 0;
  for (int i = 0; i < Database<S>::kSlots; ++i) {
    if (d->database().kept(i)) segments[n++] = &d->database().slot(i).information;
  }
  JointInformation<S> joint = d->work.sums(d->prior().sigma, d->prior().mean.columns());
  return joint.sum(segments, n);
}

/// True if the kept segments are worth a calibration: there are enough (paper, Alg. 1), or, where there are targets,
/// they predict that these will be reached.
template <class S>
[[gnu::cold]] bool knows_enough(DeviceParts<S>* d) {
  if (!has_targets(d->options.target_sigma, d->prior().mean.columns())) return d->database().full();
  return reaches_targets(sum_of_kept(d), d->prior().sigma, d->options.target_sigma, d->database().full());
}

/// True if they could convict what is older (agreement.h).
template <class S>
bool could_convict(DeviceParts<S>* d) {
  S work[kMaxTheta];
  return knows_half(sum_of_kept(d), d->prior().mean.columns(), work);
}

}  // namespace SEGCAL_NS
