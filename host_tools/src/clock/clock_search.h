// The camera's clock against the IMU's, before the filter starts: rotation seen by
// the images, matched with the gyroscope over half a second either way. A filter
// that is fed with clocks 30 ms apart does not start, or settles on a wrong answer.
#pragma once

#include <string>

#include "calibration_file.h"
#include "recording.h"

namespace host {

/// What rotation alone is systematically wrong by (parallax, lenses, rolling shutter):
/// offsets below are left to the effect time_offset, which the filter stands. By
/// motion, not by chance: three sigmas of the search do not make it smaller.
constexpr double clock_systematic_s = 0.004;

struct ClockSearch {
  bool judged = false;     ///< the motion tells one offset; else `words` says what it lacks
  double offset_s = 0;     ///< t_imu - t_cam, in all: with the start
  double sigma_s = 0;      ///< as far as rotation tells; lenses and a rolling shutter are not in it
  double correlation = 0;  ///< of the rates at the offset, 1: the same motion
  double correlation_at_start = 0;
  std::string words;  ///< a sentence

  /// The offset is not the one that was stated: the clocks have to be moved before the filter can run.
  bool differs_from(double start_s) const;
};

/// Offsets of start_s -0.5 to +0.5 s. `camera` need not be precise: a few per cent, a few degrees. Work grows with the
/// frames times the offsets tried (201), and no more.
ClockSearch search_clock(const Recording& recording, const CameraCalibration& camera, double start_s);

/// Adds the offset to the stamps of all frames: they are then of the IMU's clock, up to what is left to estimate.
void shift_frames(double offset_s, Recording* recording);

}  // namespace host
