// The device's search for the clocks' offset, fed from a recording as its sensors would.
#pragma once

#include <Eigen/Geometry>
#include <cstring>
#include <memory>
#include <vector>

#include "calibration_file.h"
#include "recording.h"
#include "segcal/clock.h"

namespace test {

inline segcal_camera_t camera_of(const host::CameraCalibration& in) {
  segcal_camera_t out = {};
  out.model = in.model == host::DistortionModel::fov      ? SEGCAL_FOV
              : in.model == host::DistortionModel::radtan ? SEGCAL_RADTAN
                                                          : SEGCAL_EQUIDISTANT;
  const Eigen::Quaterniond q(in.R_CI);
  const double wxyz[4] = {q.w(), q.x(), q.y(), q.z()};
  for (int i = 0; i < 4; ++i) {
    out.q_CI[i] = wxyz[i];
    out.intrinsics[i] = in.intrinsics[i];
    out.distortion[i] = i < (in.model == host::DistortionModel::fov ? 1 : 4) ? in.distortion[i] : 0;
  }
  return out;
}

inline segcal_imu_t sample_of(const host::ImuSample& in) {
  segcal_imu_t out = {};
  out.t_ns = in.t_ns;
  for (int i = 0; i < 3; ++i) out.gyro[i] = static_cast<float>(in.gyro[i]);
  return out;
}

inline std::vector<segcal_point_t> points_of(const host::Frame& frame) {
  std::vector<segcal_point_t> out;
  for (const host::TrackPoint& p : frame.points) {
    if (out.size() < SEGCAL_MAX_TRACKS)
      out.push_back({p.track_id, 0, static_cast<float>(p.u), static_cast<float>(p.v)});
  }
  return out;
}

/// How a search is fed.
struct Feed {
  double start_s = 0;
  double shift_s = 0;  ///< the images' stamps are early by so much: the offset is what the recording has, and this
  int slices = 1000;   ///< of background after each sample
  bool stop_when_found = false;
};

struct DeviceAnswer {
  segcal_clock_result_t result = {};
  double found_after_s = -1;  ///< of stream; -1: never
  /// largest |offset - truth| / sigma of all that was `found` on the way, where the truth was given
  double worst_of_found = 0;
  double worst_s = 0;  ///< the same in seconds
};

/// All of cam0. `truth_s`: to judge each answer on the way.
inline DeviceAnswer searched(const host::Recording& recording, const segcal_camera_t& camera, const Feed& feed,
                             double truth_s) {
  const auto clock = std::make_unique<segcal_clock_t>();
  std::memset(clock.get(), 0xA5, sizeof *clock);
  DeviceAnswer out;
  if (segcal_clock_create(clock.get(), sizeof *clock, &camera, 0, feed.start_s) != SEGCAL_OK) return out;
  const std::vector<host::Frame>& frames = recording.cameras[0].frames;
  const auto shift_ns = static_cast<std::int64_t>(1e9 * feed.shift_s);
  const auto& samples = recording.imu.samples;
  for (std::size_t i = 0, k = 0; i < samples.size(); ++i) {
    const segcal_imu_t sample = sample_of(samples[i]);
    segcal_clock_push_imu(clock.get(), &sample);
    for (; k < frames.size() && frames[k].t_ns <= sample.t_ns; ++k) {
      const std::vector<segcal_point_t> points = points_of(frames[k]);
      segcal_clock_push_tracks(clock.get(), frames[k].t_ns - shift_ns, points.data(),
                               static_cast<std::int32_t>(points.size()));
    }
    segcal_clock_background(clock.get(), feed.slices);
    if (i % 100 != 0 && i + 1 < samples.size()) continue;
    segcal_clock_get(clock.get(), &out.result);
    if (out.result.status != SEGCAL_CLOCK_FOUND) continue;
    if (out.found_after_s < 0) out.found_after_s = 1e-9 * static_cast<double>(sample.t_ns - samples.front().t_ns);
    const double off = std::abs(out.result.offset_s - truth_s);
    out.worst_s = std::max(out.worst_s, off);
    out.worst_of_found = std::max(out.worst_of_found, off / out.result.sigma_s);
    if (feed.stop_when_found) break;
  }
  return out;
}

}  // namespace test
