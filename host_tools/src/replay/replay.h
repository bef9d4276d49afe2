// Feeds recordings to the core as a device would live them, and gathers what comes out.
#pragma once

#include <functional>

#include "replay/core.h"

namespace host {

struct ReplayOptions {
  CoreOptions core;
  std::string profile = "mobile";
  bool joint_ekf = false;            ///< no segments: the filter gives the calibration itself, at the end of each session
  bool calibrate = true;             ///< false: odometry only, the calibration stays as it is
  /// Called after each session with what has been found so far; may be empty. The number counts from 0.
  std::function<void(std::size_t, const CoreResult&, const Calibration&)> after_session;
  std::unique_ptr<Core>* keep_core = nullptr;  ///< takes the core over when the replay is done, to ask it further things
  std::function<void(double)> progress;  ///< called with the fraction done, 0..1; may be empty
};

/// One calibration that ran.
struct ReplayCalibration {
  std::int64_t t_ns = 0;             ///< stamp of the newest frame then
  bool by_targets = false;           ///< the device began it of its own, else the replay did at the session's end
  int segments = 0;
  std::string status;
  std::vector<CoreParameter> parameters;
};

struct ReplayTiming {
  double vio_ms_median = 0, vio_ms_p95 = 0;  ///< per processed frame, IMU included
  double score_ms_median = 0;                ///< per segment: frames on which a segment was closed
  double calibrate_ms = 0;                   ///< the last calibration
};

struct ReplayResult {
  CoreResult result;
  bool calibrated = false;           ///< a calibration ran
  std::vector<ReplayCalibration> calibrations;
  Calibration calibration;
  Calibration start;                 ///< where it started from, the mean of the prior
  ImuNoise noise;
  CoreModel model;
  std::vector<CoreState> trajectory; ///< at each processed frame
  std::vector<CoreSegment> segments; ///< every segment scored, `kept` as at the end
  std::vector<CoreKept> kept;
  std::vector<std::pair<std::string, std::uint32_t>> counters;
  CoreMemory memory;
  ReplayTiming timing;
};

/// Replays the recordings one after the other, each as a session of the same device.
ReplayResult replay(const std::vector<Recording>& sessions, const ReplayOptions& options);

}  // namespace host
