// Segments with known truth: a device shaken along a known path, its raw IMU samples, image points of random landmarks,
// and disturbed states to start from. Noise and devices are those of the functions below.
#pragma once

#include <memory>
#include <vector>

#include "nominal.h"
#include "path.h"
#include "segments/observation_order.h"
#include "segments/triangulation.h"

namespace test {

/// What to simulate. Times in seconds.
struct SyntheticOptions {
  std::uint32_t seed = 1;
  Distortion model = Distortion::fov;
  int segments = 4, keyframes = 20, landmarks = 100;
  double keyframe_interval = 0.2;
  int shared = 0;             ///< landmarks beside these that every segment sees
  double drift = 0;           ///< rad and 3 m: how far each segment's states but the first's are off as a whole
  double gap = 0;             ///< 0: each segment's IMU samples begin at the last keyframe of the one before
  double move = 1, turn = 1;  ///< how much of the path's translation and rotation is used
  double nearest = 0.8, farthest = 5.8;  ///< m, landmarks along the optical axis when they are drawn
  double device = 1;                     ///< the device's true values: this times the usual deviation from nominal
  double track_walk = 0;                 ///< px/sqrt(s), drift of the image points along their tracks
  double start_error = 1;                ///< of the states that the segments begin with
};

class SyntheticSession {
 public:
  explicit SyntheticSession(const SyntheticOptions& options)
      : options_(options), random_(options.seed), nominal(nominal_calibration(options.model)), truth(nominal) {
    model.track_walk = options_.track_walk;
    draw_device();
    path_ = random_path(&random_, options_.move, options_.turn);
    draw_imu();
    for (int s = 0; s < options_.segments; ++s) {
      segments.push_back(std::make_unique<Segment<double>>());
      fill(s, segments.back().get());
    }
  }

 private:
  SyntheticOptions options_;
  Random random_;
  Path path_;
  std::vector<InertialReading<double>> imu_;  ///< sample i at i * kPeriod
  std::vector<Vec3<double>> b_a_, b_g_;
  std::vector<Vec3<double>> map_;  ///< the shared landmarks, track 0 and on
  std::uint32_t next_track_ = 1000;
  static constexpr double kPeriod = 0.005;

 public:
  Calibration<double> nominal, truth;
  MeasurementModel<double> model;
  std::vector<std::unique_ptr<Segment<double>>> segments;

 private:
  double duration() const { return (options_.keyframes - 1) * options_.keyframe_interval; }
  double start_of(int s) const {
    return 0.5 + s * (duration() + (options_.gap > 0 ? options_.gap : options_.keyframe_interval));
  }

  void draw_device() {
    const std::vector<double> sigma = device_sigmas(nominal);
    double step[kMaxTheta] = {};
    for (std::size_t i = 0; i < sigma.size(); ++i) step[i] = options_.device * random_.normal(sigma[i]);
    add_step(&truth, step);
  }

  void draw_imu() {
    const int count = static_cast<int>((start_of(options_.segments) + 1) / kPeriod);
    const double white = 1 / std::sqrt(kPeriod), walk = std::sqrt(kPeriod);
    Vec3<double> b_a = random_.vector(0.05), b_g = random_.vector(0.005);
    for (int i = 0; i < count; ++i) {
      b_a += random_.vector(model.imu.accel_walk * walk);
      b_g += random_.vector(model.imu.gyro_walk * walk);
      InertialReading<double> reading = measure(path_, truth.imu, b_a, b_g, i * kPeriod);
      reading.gyro += random_.vector(model.imu.gyro * white);
      reading.accel += random_.vector(model.imu.accel * white);
      imu_.push_back(reading);
      b_a_.push_back(b_a);
      b_g_.push_back(b_g);
    }
  }

  void fill(int s, Segment<double>* segment) {
    const double t0 = start_of(s);
    const bool joined = options_.gap == 0;
    segment->t0_ns = std::llround(t0 * 1e9);
    segment->serial = static_cast<std::uint32_t>(joined ? s : 2 * s);
    segment->session = 0;
    segment->n_keyframes = options_.keyframes;
    segment->lead_us = joined && s > 0 ? static_cast<std::int32_t>(std::llround(options_.keyframe_interval * 1e6)) : 0;
    store_imu(t0, segment);
    if (options_.shared > 0 && map_.empty()) draw_map();
    for (int k = 0; k < options_.keyframes; ++k) {
      segment->t_us[k] = static_cast<std::int32_t>(std::llround(k * options_.keyframe_interval * 1e6));
      segment->states.x[k] = disturbed(t0 + k * options_.keyframe_interval);
    }
    if (options_.drift > 0 && s > 0) drift(segment);
    see_landmarks(t0, segment);
    for (std::size_t i = 0; i < map_.size(); ++i)
      follow(t0, map_[i], 0, options_.keyframes, static_cast<std::uint32_t>(i), segment);
    drop_without_place(segment);
  }

  /// As the library does: a first point that nominal's lens does not image has no ray.
  void drop_without_place(Segment<double>* segment) const {
    for (int j = 0; j < segment->n_landmarks; ++j) {
      if (triangulate(segment, j, nominal, model, 1e6)) continue;
      for (int o = segment->first_observation[j]; o < segment->first_observation[j + 1]; ++o)
        segment->observation[o].landmark = kDroppedLandmark;
    }
    index_observations(segment, 1);
  }

  void store_imu(double t0, Segment<double>* segment) {
    segment->imu.clear();
    const int first = static_cast<int>((t0 - segment->lead_us * 1e-6) / kPeriod + 1e-6);
    const int last = static_cast<int>((t0 + duration()) / kPeriod + 1.5);
    for (int i = first; i <= last; ++i) {
      segment->imu.push(static_cast<std::int32_t>(std::llround((i * kPeriod - t0) * 1e6)), imu_[i]);
    }
  }

  State<double> disturbed(double t) {
    State<double> x = path_.state(t);
    const double e = options_.start_error;
    x.R_GI = x.R_GI * so3_exp<double>(random_.vector(0.003 * e));
    x.p_GI += random_.vector(0.01 * e);
    x.v_GI += random_.vector(0.03 * e);
    const std::size_t i = static_cast<std::size_t>(t / kPeriod + 0.5);
    // Biases are unknown to those who start: zero unless the start is asked to be exact.
    if (e == 0) {
      x.b_a = b_a_[i];
      x.b_g = b_g_[i];
    }
    return x;
  }

  /// A segment as a whole, turned about gravity and shifted.
  void drift(Segment<double>* segment) {
    const Mat3<double> turn = so3_exp<double>({0, 0, random_.normal(options_.drift)});
    const Vec3<double> shift = random_.vector(3 * options_.drift);
    for (int k = 0; k < segment->n_keyframes; ++k) {
      State<double>& x = segment->states.x[k];
      x.R_GI = turn * x.R_GI;
      x.p_GI = turn * x.p_GI + shift;
      x.v_GI = turn * x.v_GI;
    }
  }

  /// A landmark drawn in the image seen at t.
  bool draw_landmark(double t, Vec3<double>* in_G) {
    const Vec2<double> uv(random_.uniform(30, 610), random_.uniform(30, 450));
    const double depth = random_.uniform(options_.nearest, options_.farthest);
    Vec3<double> h;
    const CameraCalibration<double>& camera = truth.camera[0];
    if (!unproject(camera, uv, &h)) return false;
    const State<double> x = path_.state(t);
    const Vec3<double> in_C = h * depth;
    *in_G = x.p_GI + x.R_GI * (camera.R_CI.transpose() * (in_C - camera.p_CI));
    return true;
  }

  /// Landmarks that half of each segment's keyframes see.
  void draw_map() {
    for (int tries = 0; tries < 1000 * options_.shared && static_cast<int>(map_.size()) < options_.shared; ++tries) {
      Vec3<double> l;
      bool seen_by_all = draw_landmark(start_of(0), &l);
      for (int s = 0; s < options_.segments && seen_by_all; ++s) {
        int seen = 0;
        Vec2<double> uv;
        for (int k = 0; k < options_.keyframes; ++k)
          seen += image_of(l, start_of(s) + k * options_.keyframe_interval, &uv) ? 1 : 0;
        seen_by_all = 2 * seen >= options_.keyframes;
      }
      if (seen_by_all) map_.push_back(l);
    }
  }

  /// Landmarks are drawn in the image of some keyframe and followed over a few keyframes around it.
  void see_landmarks(double t0, Segment<double>* segment) {
    segment->n_landmarks = segment->n_observations = 0;
    segment->first_observation[0] = 0;
    for (int tries = 0; tries < 50 * options_.landmarks && segment->n_landmarks < options_.landmarks; ++tries) {
      const int seen_from = random_.index(options_.keyframes);
      Vec3<double> in_G;
      if (!draw_landmark(t0 + seen_from * options_.keyframe_interval, &in_G)) continue;
      const int half = random_.index(9) + 1;
      follow(t0, in_G, std::max(0, seen_from - half), std::min(options_.keyframes, seen_from + half + 1), next_track_++,
             segment);
    }
  }

  void follow(double t0, const Vec3<double>& l, int first, int end, std::uint32_t track, Segment<double>* segment) {
    const int begin = segment->n_observations;
    int n = begin;
    Vec2<double> walked(0, 0);
    for (int k = first; k < end && n < kMaxObservations; ++k) {
      Vec2<double> uv;
      if (k > first && options_.track_walk > 0)
        walked += random_.vector(options_.track_walk * std::sqrt(options_.keyframe_interval)).head<2>();
      if (!image_of(l, t0 + k * options_.keyframe_interval, &uv)) continue;
      uv += walked;
      segment->observation[n++] = {static_cast<float>(uv.x() + random_.normal(model.pixel_sigma)),
                                   static_cast<float>(uv.y() + random_.normal(model.pixel_sigma)),
                                   static_cast<std::uint16_t>(segment->n_landmarks),
                                   static_cast<std::uint8_t>(k),
                                   0,
                                   0};
    }
    if (n - begin < 3) return;
    segment->n_observations = n;
    segment->track_id[segment->n_landmarks] = track;
    segment->first_observation[++segment->n_landmarks] = static_cast<std::uint16_t>(n);
  }

  bool image_of(const Vec3<double>& l, double t, Vec2<double>* uv) const {
    const State<double> x = path_.state(t);
    const CameraCalibration<double>& camera = truth.camera[0];
    const Vec3<double> in_C = camera.R_CI * (x.R_GI.transpose() * (l - x.p_GI)) + camera.p_CI;
    if (!project(camera, in_C, uv)) return false;
    return uv->x() > 0 && uv->x() < 639 && uv->y() > 0 && uv->y() < 479;
  }
};

}  // namespace test
