// A small simulated device for the filter's tests: a smooth path, an IMU with noise and walking biases, and a camera
// that tracks points which it picked at random. Everything is drawn from one seed.
#pragma once

#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include "vio/vio.h"

namespace vio_test {

using namespace SEGCAL_NS;

class Random {
 public:
  explicit Random(std::uint64_t seed) : bits_(seed * 7919 + 17) {}
  double uniform(double a, double b) { return a + (b - a) * (static_cast<double>(bits_() >> 11) / 9007199254740992.0); }
  double normal(double sigma) {  // Box and Muller; the standard library's normal_distribution differs between vendors
    const double u = 1.0 - uniform(0, 1), v = uniform(0, 1);
    return sigma * std::sqrt(-2.0 * std::log(u)) * std::cos(2.0 * 3.14159265358979 * v);
  }
  Vec3<double> normal3(double sigma) {
    const double x = normal(sigma), y = normal(sigma), z = normal(sigma);
    return Vec3<double>(x, y, z);
  }

 private:
  std::mt19937_64 bits_;
};

struct Scene {
  std::uint64_t seed = 1;
  double seconds = 20;
  double rest_until = 0;   ///< s at rest at the beginning
  double rest_from = 1e9;  ///< s; from here it stands still again
  double sway = 0;         ///< m, and rad: a hand that tries to hold still
  double pixel_noise = 0.5;
  double track_walk = 0;  ///< px/sqrt(s); random walk of a corner's error along its track
  double gyro_bias = 0.02, accel_bias = 0.1;
  double r_CI_error = 0.01, p_CI_error = 0.005;  ///< sigma of the filter's initial extrinsics
  double focal_error = 0;   ///< share of f; sigma of the filter's initial intrinsics, 0: exact and not estimated
  double centre_error = 6;  ///< px
  double distortion_error = 0.02;
  double imu_error = 0;  ///< scale, misalignment and rotation (rad) of the accelerometer; the gyroscope's: half
  double outliers = 0;   ///< share of tracks that slide over the image
  int tracks = 60;
  int cameras = 1;  ///< 2: every second point is seen by both, under one id; every seventh frame cam1 is blind
};

/// Path and attitude: sums of sinusoids with random phases, slowed down to rest where the scene says so.
class Path {
 public:
  Path(const Scene& scene, Random* random) : scene_(scene) {
    for (int i = 0; i < 6; ++i) {
      for (int k = 0; k < 2; ++k) {
        frequency_[i][k] = random->uniform(0.15, 0.5) * (k ? 1.9 : 1.0);
        phase_[i][k] = random->uniform(0, 6.28);
        amplitude_[i][k] = (i < 3 ? random->uniform(0.3, 0.7) : random->uniform(0.15, 0.4)) / (k ? 2.5 : 1.0);
      }
    }
  }
  Vec3<double> position(double t) const { return Vec3<double>(wave(0, t), wave(1, t), 0.6 * wave(2, t)) + sway(t); }
  Mat3<double> attitude(double t) const {
    const double s = warped(t);
    const Mat3<double> yaw = so3_exp<double>(Vec3<double>(0, 0, 0.15 * s + 2 * wave(5, t)));
    return yaw * so3_exp<double>(Vec3<double>(0, wave(4, t), 0)) * so3_exp<double>(Vec3<double>(wave(3, t), 0, 0)) *
           so3_exp<double>(sway(t + 0.3));
  }
  Vec3<double> velocity(double t) const { return (position(t + 1e-4) - position(t - 1e-4)) / 2e-4; }
  Vec3<double> acceleration(double t) const {
    return (position(t + 1e-3) - 2 * position(t) + position(t - 1e-3)) / 1e-6;
  }
  Vec3<double> rate(double t) const {
    return so3_log<double>(attitude(t - 1e-4).transpose() * attitude(t + 1e-4)) / 2e-4;
  }

 private:
  /// Time along the path: starts and stops smoothly over one second.
  double warped(double t) const {
    const auto ramp = [](double x) {  // integral of smoothstep
      if (x <= 0) return 0.0;
      if (x >= 1) return x - 0.5;
      return x * x * x - 0.5 * x * x * x * x;
    };
    const double start = scene_.rest_until > 0 ? ramp(t - scene_.rest_until) : t;
    return start - ramp(t - scene_.rest_from);
  }
  double wave(int i, double t) const {
    double sum = 0;
    for (int k = 0; k < 2; ++k) {
      sum += amplitude_[i][k] * std::sin(6.2831853 * frequency_[i][k] * warped(t) + phase_[i][k]);
    }
    return sum;
  }
  Vec3<double> sway(double t) const {
    return scene_.sway * Vec3<double>(std::sin(5.0 * t), std::sin(6.3 * t + 1), std::sin(4.1 * t + 2));
  }
  Scene scene_;
  double frequency_[6][2], phase_[6][2], amplitude_[6][2];
};

struct TrueFrame {
  std::int64_t t_ns;
  State<double> x;
  std::vector<TrackPoint<double>> points;
};

struct Recording {
  Calibration<double> truth, initial;
  ImuNoise<double> noise;
  std::vector<std::int64_t> imu_time;
  std::vector<InertialReading<double>> imu;
  std::vector<TrueFrame> frames;
};

inline Calibration<double> simulated_device(int cameras = 1) {
  Calibration<double> theta;
  theta.n_cameras = cameras;
  CameraCalibration<double>& camera = theta.camera[0];
  camera.model = Distortion::fov;
  camera.intrinsics << 256, 256, 320, 240;
  camera.distortion << 0.92, 0, 0, 0;
  camera.R_CI << 0, -1, 0, 0, 0, -1, 1, 0, 0;  // looks along x of I
  camera.p_CI = Vec3<double>(0.03, -0.02, 0.05);
  if (cameras == 2) {
    theta.camera[1] = camera;
    theta.camera[1].R_CI = so3_exp<double>(Vec3<double>(0.02, 0.1, -0.03)) * camera.R_CI;
    theta.camera[1].p_CI = Vec3<double>(-0.07, -0.02, 0.05);
  }
  return theta;
}

struct SimulatedTrack {
  std::uint32_t id;
  int frames_left;
  Vec3<double> l;             ///< m, in G
  Vec2<double> slide;         ///< px per frame; an outlier's own motion
  Vec2<double> walked{0, 0};  ///< px
  int age;
};

/// A point behind a random pixel of its camera at x.
inline SimulatedTrack new_track(const Calibration<double>& theta, const State<double>& x, const Scene& scene,
                                std::uint32_t id, Random* random) {
  const CameraCalibration<double>& camera = theta.camera[id % theta.n_cameras];
  const Vec2<double> uv(random->uniform(20, 620), random->uniform(20, 460));
  Vec3<double> h(0, 0, 1);
  unproject(camera, uv, &h);
  h *= random->uniform(1.5, 8.0) / h.norm();
  SimulatedTrack track;
  track.id = id;
  track.frames_left = static_cast<int>(random->uniform(6, 46));
  track.l = x.p_GI + x.R_GI * (camera.R_CI.transpose() * (h - camera.p_CI));
  const bool outlier = random->uniform(0, 1) < scene.outliers;
  track.slide = outlier ? Vec2<double>(random->uniform(-6, 6), random->uniform(-6, 6)) : Vec2<double>(0, 0);
  track.age = 0;
  return track;
}

/// Where a camera sees a track, with noise.
inline bool see_track(const CameraCalibration<double>& camera, const Scene& scene, const State<double>& x,
                      const SimulatedTrack& track, Random* random, Vec2<double>* uv) {
  const Vec3<double> p_I = x.R_GI.transpose() * (track.l - x.p_GI);
  if (!project<double>(camera, camera.R_CI * p_I + camera.p_CI, uv)) return false;
  *uv += track.slide * track.age + track.walked;
  if (uv->x() < 0 || uv->x() > 640 || uv->y() < 0 || uv->y() > 480) return false;
  *uv += Vec2<double>(random->normal(scene.pixel_noise), random->normal(scene.pixel_noise));
  return true;
}

/// The image points of one frame; tracks that left the image of their camera or are too old are replaced.
inline void observe_frame(const Calibration<double>& theta, const Scene& scene, bool blind,
                          std::vector<SimulatedTrack>* tracks, std::uint32_t* next_id, Random* random,
                          TrueFrame* frame) {
  while (static_cast<int>(tracks->size()) < scene.tracks) {
    tracks->push_back(new_track(theta, frame->x, scene, (*next_id)++, random));
  }
  std::vector<SimulatedTrack> kept;
  for (SimulatedTrack& track : *tracks) {
    const double step = scene.track_walk * std::sqrt(0.1);  // from frame to frame
    if (step > 0) track.walked += Vec2<double>(random->normal(step), random->normal(step));
    const int home = static_cast<int>(track.id) % theta.n_cameras;
    Vec2<double> uv;
    if (track.frames_left-- <= 0 || !see_track(theta.camera[home], scene, frame->x, track, random, &uv)) continue;
    if (!(blind && home == 1)) frame->points.push_back({track.id, home, uv});
    const bool shared = theta.n_cameras == 2 && track.id % 4 < 2 && !(blind && home == 0);
    if (shared && see_track(theta.camera[1 - home], scene, frame->x, track, random, &uv)) {
      frame->points.push_back({track.id, 1 - home, uv});
    }
    ++track.age;
    kept.push_back(track);
  }
  *tracks = kept;
}

inline void simulate_imu(const Scene& scene, const Path& path, Random* random, Recording* out,
                         std::vector<State<double>>* biases) {
  const double dt = 0.005;
  const Vec3<double> g(0, 0, -9.80665);
  Vec3<double> b_g = random->normal3(scene.gyro_bias), b_a = random->normal3(scene.accel_bias);
  for (int i = 0; i * dt <= scene.seconds + 0.02; ++i) {
    const double t = i * dt;
    InertialReading<double> r;
    const ImuCalibration<double>& imu = out->truth.imu;
    const Vec3<double> f = path.attitude(t).transpose() * (path.acceleration(t) - g);
    r.gyro = scale_misalignment(imu.gyro_scale, imu.gyro_misalignment) * path.rate(t) + b_g +
             random->normal3(out->noise.gyro / std::sqrt(dt));
    r.accel = scale_misalignment(imu.accel_scale, imu.accel_misalignment) * (imu.R_AI * f) + b_a +
              random->normal3(out->noise.accel / std::sqrt(dt));
    out->imu.push_back(r);
    out->imu_time.push_back(1000000000 + static_cast<std::int64_t>(i) * 5000000);
    State<double> x;
    x.b_a = b_a;
    x.b_g = b_g;
    biases->push_back(x);
    b_g += random->normal3(out->noise.gyro_walk * std::sqrt(dt));
    b_a += random->normal3(out->noise.accel_walk * std::sqrt(dt));
  }
}

inline Recording simulate(const Scene& scene) {
  Random random(scene.seed);
  const Path path(scene, &random);
  Recording out;
  out.truth = out.initial = simulated_device(scene.cameras);
  for (int c = 0; c < scene.cameras; ++c) {
    CameraCalibration<double>& camera = out.initial.camera[c];
    camera.R_CI = so3_exp<double>(random.normal3(scene.r_CI_error)) * out.truth.camera[c].R_CI;
    camera.p_CI += random.normal3(scene.p_CI_error);
    if (scene.focal_error == 0) continue;
    const double f = random.normal(scene.focal_error);
    camera.intrinsics += Vec<double, 4>(256 * (f + random.normal(0.2 * scene.focal_error)), 256 * f,
                                        random.normal(scene.centre_error), random.normal(scene.centre_error));
    camera.distortion(0) += random.normal(scene.distortion_error);
  }
  if (scene.imu_error > 0) {
    ImuCalibration<double>& imu = out.truth.imu;
    imu.gyro_scale += random.normal3(scene.imu_error / 2);
    imu.gyro_misalignment += random.normal3(scene.imu_error / 2);
    imu.accel_scale += random.normal3(scene.imu_error);
    imu.accel_misalignment += random.normal3(scene.imu_error);
    imu.R_AI = so3_exp<double>(random.normal3(scene.imu_error));
  }
  std::vector<State<double>> biases;
  simulate_imu(scene, path, &random, &out, &biases);
  std::vector<SimulatedTrack> tracks;
  std::uint32_t next_id = 1;
  for (int k = 1; k * 0.1 <= scene.seconds; ++k) {
    TrueFrame frame;
    const int sample = k * 20;
    const double t = sample * 0.005;
    frame.t_ns = out.imu_time[sample];
    frame.x = biases[sample];
    frame.x.R_GI = path.attitude(t);
    frame.x.p_GI = path.position(t);
    frame.x.v_GI = path.velocity(t);
    observe_frame(out.truth, scene, k % 7 == 0, &tracks, &next_id, &random, &frame);
    out.frames.push_back(frame);
  }
  return out;
}

// ---- The same in the filter's arithmetic ------------------------------------------------------------------------

template <class S>
Calibration<S> cast(const Calibration<double>& a) {
  Calibration<S> b;
  b.n_cameras = a.n_cameras;
  for (int c = 0; c < a.n_cameras; ++c) {
    b.camera[c].model = a.camera[c].model;
    b.camera[c].R_CI = a.camera[c].R_CI.cast<S>();
    b.camera[c].p_CI = a.camera[c].p_CI.cast<S>();
    b.camera[c].intrinsics = a.camera[c].intrinsics.cast<S>();
    b.camera[c].distortion = a.camera[c].distortion.cast<S>();
  }
  b.imu.gyro_scale = a.imu.gyro_scale.cast<S>();
  b.imu.gyro_misalignment = a.imu.gyro_misalignment.cast<S>();
  b.imu.accel_scale = a.imu.accel_scale.cast<S>();
  b.imu.accel_misalignment = a.imu.accel_misalignment.cast<S>();
  b.imu.R_AI = a.imu.R_AI.cast<S>();
  return b;
}

/// A filter with its IMU history, fed frame by frame.
template <class S>
class Replay {
 public:
  Replay(const Recording& recording, const VioOptions<S>& options) : recording_(recording), next_(0) {
    history_.clear();
    vio.reset(cast<S>(recording.initial), options);
  }

  VioStatus push(const TrueFrame& frame) {
    while (next_ < recording_.imu.size() && (history_.size() < 2 || history_.newest() < frame.t_ns)) {
      const InertialReading<double>& r = recording_.imu[next_];
      history_.push(recording_.imu_time[next_], {r.gyro.cast<S>(), r.accel.cast<S>()});
      ++next_;
    }
    points_.clear();
    for (const TrackPoint<double>& p : frame.points) points_.push_back({p.id, p.camera, p.uv.cast<S>()});
    return vio.push_frame(frame.t_ns, points_.data(), static_cast<int>(points_.size()), history_);
  }

  Vio<S> vio;

 private:
  const Recording& recording_;
  ImuHistory<S> history_;
  std::vector<TrackPoint<S>> points_;
  std::size_t next_;
};

template <class S>
VioOptions<S> options_for(const Scene& scene) {
  VioOptions<S> options;
  options.pixel_sigma = static_cast<S>(scene.pixel_noise);
  options.track_walk = static_cast<S>(scene.track_walk);
  options.sigma_r_CI = static_cast<S>(scene.r_CI_error);
  options.sigma_p_CI = static_cast<S>(scene.p_CI_error);
  options.sigma_focal = static_cast<S>(scene.focal_error);
  options.sigma_centre = static_cast<S>(scene.centre_error);
  options.sigma_distortion = static_cast<S>(scene.distortion_error);
  options.sigma_gyro = static_cast<S>(scene.imu_error / 2);
  options.sigma_accel = options.sigma_r_AI = static_cast<S>(scene.imu_error);
  return options;
}

/// Yaw and shift that carry the simulated world into the filter's: place and heading are free, the filter fixes them at
/// the first pose of its first window.
struct Gauge {
  Mat3<double> R = Mat3<double>::Identity();
  Vec3<double> p = Vec3<double>::Zero();

  template <class S>
  void fix(const WindowPose<S>& pose, const State<double>& truth) {
    const Mat3<double> R_GI = pose.R_GI.template cast<double>();
    double yaw = 0;
    for (int i = 0; i < 20; ++i) {  // error seen in G: its z part vanishes
      R = so3_exp<double>(Vec3<double>(0, 0, yaw));
      yaw -= (R_GI * so3_log<double>(R_GI.transpose() * R * truth.R_GI)).z();
    }
    R = so3_exp<double>(Vec3<double>(0, 0, yaw));
    p = pose.p_GI.template cast<double>() - R * truth.p_GI;
  }
  /// Errors of an estimate in the filter's columns [theta p v b_a b_g]: truth minus estimate.
  template <class S>
  Vec<double, 15> error(const State<S>& x, const State<double>& truth) const {
    Vec<double, 15> e;
    const Mat3<double> R_GI = x.R_GI.template cast<double>();
    e.segment<3>(0) = so3_log<double>(R_GI.transpose() * (R * truth.R_GI));
    e.segment<3>(3) = R * truth.p_GI + p - x.p_GI.template cast<double>();
    e.segment<3>(6) = R * truth.v_GI - x.v_GI.template cast<double>();
    e.segment<3>(9) = truth.b_a - x.b_a.template cast<double>();
    e.segment<3>(12) = truth.b_g - x.b_g.template cast<double>();
    return e;
  }
};

}  // namespace vio_test
