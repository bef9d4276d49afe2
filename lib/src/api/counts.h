// What a device counts: faults of its data, slices of its work.
#pragma once

#include <cstdint>

#include "segcal/config.h"

namespace SEGCAL_NS {

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

/// Of the samples and frames that came, those that were refused, that
/// are at full scale or come after a gap, and frames with few points.
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

}  // namespace SEGCAL_NS
