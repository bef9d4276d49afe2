#include "disturb.h"

#include <algorithm>
#include <cmath>

#include "random.h"

namespace host::disturb {
namespace {

constexpr std::int64_t least_step_ns = 1000;

std::array<double, 3>& values_of(ImuSample& sample, Sensor sensor) {
  return sensor == Sensor::gyro ? sample.gyro : sample.accel;
}

void clip_values(std::array<double, 3>& values, double limit) {
  if (!(limit > 0)) return;
  for (double& v : values) v = std::clamp(v, -limit, limit);
}

template <typename Stamped>
void jitter(std::vector<Stamped>& entries, double sigma_s, sim::Random& random) {
  if (!(sigma_s > 0)) return;
  std::int64_t last_ns = INT64_MIN + least_step_ns;
  for (Stamped& entry : entries) {
    entry.t_ns =
        std::max<std::int64_t>(entry.t_ns + std::llround(1e9 * sigma_s * random.normal()), last_ns + least_step_ns);
    last_ns = entry.t_ns;
  }
}

/// Sign and source of each axis.
std::array<std::pair<double, std::size_t>, 3> parse_axes(const std::string& axes) {
  std::array<std::pair<double, std::size_t>, 3> out;
  std::size_t n = 0;
  double sign = 1;
  bool used[3] = {false, false, false};
  for (char c : axes) {
    if (c == '-') {
      sign = -1;
      continue;
    }
    const auto axis = static_cast<std::size_t>(c - 'x');
    if (c < 'x' || c > 'z' || n == 3 || used[axis]) {
      throw InputError("axes: expected x, y and z once each, with or without '-', as in yx-z, found '" + axes + "'");
    }
    used[axis] = true;
    out[n++] = {sign, axis};
    sign = 1;
  }
  if (n != 3) throw InputError("axes: expected three, as in yx-z, found '" + axes + "'");
  return out;
}

}  // namespace

void clip(Recording& recording, double gyro_limit, double accel_limit) {
  for (ImuSample& sample : recording.imu.samples) {
    clip_values(sample.gyro, gyro_limit);
    clip_values(sample.accel, accel_limit);
  }
}

void drop_imu_samples(Recording& recording, int every_n) {
  std::vector<ImuSample> kept;
  for (std::size_t k = 0; k < recording.imu.samples.size(); ++k)
    if ((k + 1) % static_cast<std::size_t>(every_n) != 0) kept.push_back(recording.imu.samples[k]);
  recording.imu.samples = std::move(kept);
}

void jitter_stamps(Recording& recording, double imu_sigma_s, double camera_sigma_s, std::uint64_t seed) {
  sim::Random random(seed, sim::Stream::stamps);
  jitter(recording.imu.samples, imu_sigma_s, random);
  for (CameraData& camera : recording.cameras) {
    sim::Random same_for_all_cameras(seed + 1, sim::Stream::stamps);  // of a rig that is triggered together
    jitter(camera.frames, camera_sigma_s, same_for_all_cameras);
  }
}

void freeze(Recording& recording, Sensor sensor, std::int64_t t_ns, double seconds) {
  const std::int64_t end_ns = t_ns + std::llround(1e9 * seconds);
  const std::array<double, 3>* held = nullptr;
  for (ImuSample& sample : recording.imu.samples) {
    if (sample.t_ns < t_ns || sample.t_ns >= end_ns) continue;
    if (!held) held = &values_of(sample, sensor);
    values_of(sample, sensor) = *held;
  }
}

void scale(Recording& recording, Sensor sensor, const Eigen::Vector3d& factor, std::int64_t t_ns) {
  for (ImuSample& sample : recording.imu.samples) {
    if (sample.t_ns < t_ns) continue;
    for (std::size_t i = 0; i < 3; ++i) values_of(sample, sensor)[i] *= factor[static_cast<Eigen::Index>(i)];
  }
}

void offset(Recording& recording, Sensor sensor, const Eigen::Vector3d& by, std::int64_t t_ns) {
  for (ImuSample& sample : recording.imu.samples) {
    if (sample.t_ns < t_ns) continue;
    for (std::size_t i = 0; i < 3; ++i) values_of(sample, sensor)[i] += by[static_cast<Eigen::Index>(i)];
  }
}

void reorder_axes(Recording& recording, Sensor sensor, const std::string& axes) {
  const auto order = parse_axes(axes);
  for (ImuSample& sample : recording.imu.samples) {
    const std::array<double, 3> old = values_of(sample, sensor);
    for (std::size_t i = 0; i < 3; ++i) values_of(sample, sensor)[i] = order[i].first * old[order[i].second];
  }
}

void shift_camera_stamps(Recording& recording, double shift_s, double drift) {
  for (CameraData& camera : recording.cameras) {
    const std::int64_t first_ns = camera.frames.empty() ? 0 : camera.frames.front().t_ns;
    for (Frame& frame : camera.frames)
      frame.t_ns += std::llround(1e9 * shift_s + drift * static_cast<double>(frame.t_ns - first_ns));
    for (ImageEntry& image : camera.images) image.t_ns += std::llround(1e9 * shift_s);
  }
}

void add_g_sensitivity(Recording& recording, const Eigen::Matrix3d& T_gs) {
  for (ImuSample& sample : recording.imu.samples) {
    const Eigen::Vector3d added = T_gs * Eigen::Vector3d(sample.accel[0], sample.accel[1], sample.accel[2]);
    for (std::size_t i = 0; i < 3; ++i) sample.gyro[i] += added[static_cast<Eigen::Index>(i)];
  }
}

std::int64_t middle_ns(const Recording& recording) {
  const auto& samples = recording.imu.samples;
  if (samples.empty()) return 0;
  return samples.front().t_ns + (samples.back().t_ns - samples.front().t_ns) / 2;
}

}  // namespace host::disturb
