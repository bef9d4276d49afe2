// A device of profile mobile that lives through a simulated session, for benchmarks: only the C API, so that what is
// measured is the core as firmware compiles it.
#pragma once

#include <Eigen/Geometry>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <stdexcept>
#include <vector>

#include "segcal/segcal.h"
#include "simulate/simulate.h"

namespace bench {

/// What all benchmarks run on: 100 tracks of 6 to 45 frames, IMU 200 Hz, camera 10 Hz, so that the filter's window of
/// 20 poses is always full.
inline host::SimulationResult simulated_session() {
  host::SimulationOptions options;
  options.scenario = "rich";
  options.seconds = 60;
  options.seed = 1;
  options.tracks.count = 100;
  return host::simulate(options);
}

inline segcal_config_t config_of(const host::SimulationResult& session) {
  const host::CameraCalibration& camera = session.nominal.cameras[0];
  const Eigen::Quaterniond q(camera.R_CI);
  segcal_config_t config{};
  segcal_camera_t& c = config.camera[0];
  c.model = static_cast<std::int32_t>(camera.model);
  const double q_CI[4] = {q.w(), q.x(), q.y(), q.z()};
  for (int i = 0; i < 4; ++i) {
    c.q_CI[i] = q_CI[i];
    c.intrinsics[i] = camera.intrinsics[i];
    c.distortion[i] = camera.distortion[i];
  }
  for (int i = 0; i < 3; ++i) c.p_CI[i] = camera.p_CI[i];
  config.trigger_fraction = -1;  // calibrates where the benchmark says so
  return config;
}

/// The samples up to a frame, and the frame: what arrives at a device every 0.1 s.
struct Portion {
  std::vector<segcal_imu_t> imu;
  std::int64_t t_ns = 0;
  std::vector<segcal_point_t> points;
};

inline segcal_imu_t sample_of(const host::ImuSample& s) {
  segcal_imu_t out{};
  out.t_ns = s.t_ns;
  for (int i = 0; i < 3; ++i) {
    out.gyro[i] = static_cast<float>(s.gyro[i]);
    out.accel[i] = static_cast<float>(s.accel[i]);
  }
  return out;
}

inline std::vector<Portion> portions_of(const host::SimulationResult& session) {
  std::vector<Portion> out;
  auto next = session.recording.imu.samples.begin();
  for (const host::Frame& frame : session.recording.cameras[0].frames) {
    Portion portion;
    portion.t_ns = frame.t_ns;
    bool reached = false;
    for (; next != session.recording.imu.samples.end() && !reached; ++next) {
      reached = next->t_ns >= frame.t_ns;
      portion.imu.push_back(sample_of(*next));
    }
    for (const host::TrackPoint& p : frame.points) {
      portion.points.push_back({p.track_id, 0, static_cast<float>(p.u), static_cast<float>(p.v)});
    }
    out.push_back(portion);
  }
  return out;
}

class BenchDevice {
 public:
  explicit BenchDevice(const host::SimulationResult& session)
      : bytes_((segcal_storage_bytes() + SEGCAL_STORAGE_ALIGNMENT - 1) / SEGCAL_STORAGE_ALIGNMENT *
               SEGCAL_STORAGE_ALIGNMENT),
        storage_(std::aligned_alloc(SEGCAL_STORAGE_ALIGNMENT, bytes_)) {
    const segcal_config_t config = config_of(session);
    if (segcal_create(&device_, &config, storage_.get(), bytes_) != SEGCAL_OK)
      throw std::runtime_error("segcal_create");
  }

  /// The background has all the time: a segment that ends is scored here.
  int feed(const Portion& portion) {
    for (const segcal_imu_t& sample : portion.imu) segcal_push_imu(device_, &sample);
    const int answer = segcal_push_tracks(device_, portion.t_ns, portion.points.data(),
                                          static_cast<std::int32_t>(portion.points.size()));
    segcal_background(device_, INT32_MAX);
    return answer;
  }

  /// Segments ended so far, whether kept or not.
  std::uint32_t closed() const {
    segcal_counters_t counters{};
    segcal_get_counters(device_, &counters);
    return counters.segments_closed;
  }

  /// All of a device is in its storage: a copy is a photograph that restore() goes back to.
  std::vector<char> photograph() const {
    const char* first = static_cast<const char*>(storage_.get());
    return std::vector<char>(first, first + bytes_);
  }
  void restore(const std::vector<char>& photograph) { std::memcpy(storage_.get(), photograph.data(), bytes_); }

  segcal_t* get() { return device_; }

 private:
  struct Free {
    void operator()(void* p) const { std::free(p); }
  };
  std::size_t bytes_;
  std::unique_ptr<void, Free> storage_;
  segcal_t* device_ = nullptr;
};

class Stopwatch {
 public:
  double seconds() const { return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count(); }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace bench
