// What a device is made of, as its jobs (jobs.h) see it, and its options.
#pragma once

#include "api/counts.h"
#include "api/release.h"
#include "api/workspace.h"
#include "calibration/changes.h"
#include "calibration/condenser.h"
#include "calibration/course.h"
#include "calibration/epochs.h"
#include "database/database.h"
#include "diagnosis/effect_monitor.h"
#include "segments/builder.h"

namespace SEGCAL_NS {

template <class S>
struct DeviceOptions {
  ThetaPrior<S> prior;  ///< its mean is the starting calibration
  S sigma_ref[kMaxTheta] = {};
  /// calibration starts when the kept segments predict these; all 0: when the database is full
  S target_sigma[kMaxTheta] = {};
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
  /// probability that a calibration drops segments although theta is the same; 0: never drops any
  S outdated_level = S(1e-3);
  bool condense = false;          ///< segments that end once theta was released go into epochs, not into the database
  bool calibrates_itself = true;  ///< when it knows enough; else only where it is told to
  std::int32_t calibration_window = 4;  ///< ends of segments from its beginning until it takes effect
};

/// What the stream touches little: segments, the open one too, and what a
/// calibration from them needs. It may lie in a block of memory of its own.
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
  std::conditional_t<(kHistory > 0), History<S>, NoHistory<S>> history;
  FaultCounts faults;
  SliceCounts slices;

  const ThetaPrior<S>& prior() const { return options.prior; }
};

/// What a segment says, linearised at `at`, goes into the history.
template <class S>
void remember(const Segment<S>& segment, const Calibration<S>& at, DeviceParts<S>* d) {
  if constexpr (kHistory > 0) {
    if (d->options.condense) d->history.add(segment.information, at, segment.session, mean_warmth(segment));
  }
}

/// Triangle of the prior and the kept segments, each alone, in units of the prior's sigmas; in the workspace.
template <class S>
PackedTriangle<S> sum_of_kept(DeviceParts<S>* d, typename Workspace<S>::Lease* work) {
  const SegmentInformation<S>* segments[kMaxSegments];
  int n = 0;
  for (int i = 0; i < Database<S>::kSlots; ++i) {
    if (d->database().kept(i)) segments[n++] = &d->database().slot(i).information;
  }
  JointInformation<S> joint = work->sums(d->prior().sigma, d->prior().mean.columns());
  return joint.sum(segments, n);
}

/// True if the kept segments are worth a calibration: there are enough (paper, Alg. 1), or, where there are targets,
/// they predict that these will be reached.
template <class S>
[[gnu::cold]] bool knows_enough(DeviceParts<S>* d) {
  if (!has_targets(d->options.target_sigma, d->prior().mean.columns())) return d->database().full();
  typename Workspace<S>::Lease work;
  d->work.begin_lease(WorkOwner::question, &work);
  const bool reached =
      reaches_targets(sum_of_kept(d, &work), d->prior().sigma, d->options.target_sigma, d->database().full());
  work.end();
  return reached;
}

/// True if they could convict what is older (agreement.h).
template <class S>
bool could_convict(DeviceParts<S>* d) {
  S solved[kMaxTheta];
  typename Workspace<S>::Lease work;
  d->work.begin_lease(WorkOwner::question, &work);
  const bool could = knows_half(sum_of_kept(d, &work), d->prior().mean.columns(), solved);
  work.end();
  return could;
}

}  // namespace SEGCAL_NS
