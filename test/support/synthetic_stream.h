// The stream of samples that a device pushes through the C API: IMU at 200 Hz and the tracks of a few hundred landmarks
// at 10 Hz, from a known path.
#pragma once

#include <segcal/segcal.h>

#include <vector>

#include "path.h"
#include "sensors/camera.h"

namespace test {

class SyntheticStream {
 public:
  struct Frame {
    segcal_state_t state;  ///< the true one
    std::vector<segcal_point_t> points;
  };
  std::vector<segcal_imu_t> imu;
  std::vector<Frame> frames;  ///< frame i has the stamp of IMU sample 20 i

  /// `rest_s`: it stands still for so long.
  SyntheticStream(std::uint32_t seed, double seconds, double rest_s = 0) : random_(seed) {
    path_ = random_path(&random_, 1, 1);
    path_.rest_s = rest_s;
    camera_.model = Distortion::fov;
    camera_.intrinsics << 256, 256, 320, 240;
    camera_.distortion << 0.92, 0, 0, 0;
    camera_.R_CI << 0, -1, 0, 0, 0, -1, 1, 0, 0;
    camera_.p_CI << 0.02, -0.03, 0.05;
    for (int i = 0; i < 400; ++i) landmarks_.push_back(random_.direction() * random_.uniform(2, 6));
    for (int i = 0; i < seconds * 200; ++i) add_sample(i);
    for (int i = 0; i < seconds * 10; ++i) add_frame(i);
  }

  /// The configuration of such a device; zeroes elsewhere mean defaults.
  static segcal_config_t config() {
    segcal_config_t c = segcal_config_t();
    c.camera[0].model = SEGCAL_FOV;
    const double q[4] = {0.5, 0.5, -0.5, 0.5}, p[3] = {0.02, -0.03, 0.05}, k[4] = {256, 256, 320, 240};
    for (int i = 0; i < 4; ++i) c.camera[0].q_CI[i] = q[i];
    for (int i = 0; i < 3; ++i) c.camera[0].p_CI[i] = p[i];
    for (int i = 0; i < 4; ++i) c.camera[0].intrinsics[i] = k[i];
    c.camera[0].distortion[0] = 0.92;
    c.keep_segments = 2;
    c.segment_s = 2;
    return c;
  }

 private:
  static std::int64_t stamp(int sample) { return 1000000000 + std::int64_t(sample) * 5000000; }

  void add_sample(int i) {
    const InertialReading<double> r =
        measure(path_, ImuCalibration<double>(), {0.05, -0.03, 0.02}, {0.004, 0.002, -0.003}, i * 0.005);
    segcal_imu_t sample;
    sample.t_ns = stamp(i);
    for (int c = 0; c < 3; ++c) {
      sample.gyro[c] = static_cast<float>(r.gyro(c) + random_.normal(1.7e-4 * std::sqrt(200.0)));
      sample.accel[c] = static_cast<float>(r.accel(c) + random_.normal(2e-3 * std::sqrt(200.0)));
    }
    imu.push_back(sample);
  }

  void add_frame(int i) {
    const State<double> x = path_.state(i * 0.1);
    Frame frame;
    frame.state = segcal_state_t();
    frame.state.t_ns = stamp(20 * i);
    const Vec<double, 4> q = quaternion_from_matrix(x.R_GI);
    for (int c = 0; c < 4; ++c) frame.state.q_GI[c] = q(c);
    for (int c = 0; c < 3; ++c) {
      frame.state.p_GI[c] = x.p_GI(c);
      frame.state.v_GI[c] = x.v_GI(c);
    }
    for (std::size_t j = 0; j < landmarks_.size() && frame.points.size() < 60; ++j) {
      const Vec3<double> in_C = camera_.R_CI * (x.R_GI.transpose() * (landmarks_[j] - x.p_GI)) + camera_.p_CI;
      Vec2<double> uv;
      if (!project(camera_, in_C, &uv) || uv.x() < 0 || uv.x() > 639 || uv.y() < 0 || uv.y() > 479) continue;
      frame.points.push_back({static_cast<std::uint32_t>(j), 0, static_cast<float>(uv.x() + random_.normal(0.5)),
                              static_cast<float>(uv.y() + random_.normal(0.5))});
    }
    frames.push_back(frame);
  }

  Random random_;
  Path path_;
  CameraCalibration<double> camera_;
  std::vector<Vec3<double>> landmarks_;
};

}  // namespace test
