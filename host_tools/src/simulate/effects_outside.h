// Effects of real sensors that the catalogue has no entry for, for tests of what diagnosis says when it cannot know.
#pragma once

#include "effects_imu.h"

namespace host::sim {

/// Play: each axis of the gyroscope follows the true rate only when that has moved by more than `width`, rad/s, away.
class GyroHysteresis : public ImuEffect {
 public:
  explicit GyroHysteresis(double width) : width_(width) {}
  EffectTruth truth() const override { return {"outside:gyro_hysteresis", {{"width", width_, "rad/s"}}}; }
  void on_imu(const ImuMoment& moment, ImuReading& reading) const override;

 private:
  double width_;
  mutable double last_t_ = 0;  ///< readings come in order of time; a step back begins another recording
  mutable Eigen::Vector3d held_ = Eigen::Vector3d::Zero();
  mutable bool began_ = false;
};

/// Each axis of the accelerometer shifts by k times the variance
/// of the specific force along it over the last half second.
class VibrationRectification : public ImuEffect {
 public:
  explicit VibrationRectification(double k) : k_(k) {}
  EffectTruth truth() const override { return {"outside:vibration_rectification", {{"k", k_, "s^2/m"}}}; }
  void on_imu(const ImuMoment& moment, ImuReading& reading) const override;

 private:
  double k_;
};

/// Accelerometer += k (sin 2 roll, sin 2 pitch, 0): an error that depends on the attitude to gravity.
class AttitudeError : public ImuEffect {
 public:
  explicit AttitudeError(double k) : k_(k) {}
  EffectTruth truth() const override { return {"outside:attitude_error", {{"k", k_, "m/s^2"}}}; }
  void on_imu(const ImuMoment& moment, ImuReading& reading) const override;

 private:
  double k_;
};

/// Gyroscope += k (cos yaw, sin yaw, sin 2 yaw): a magnetic field beside the sensor.
class HeadingError : public ImuEffect {
 public:
  explicit HeadingError(double k) : k_(k) {}
  EffectTruth truth() const override { return {"outside:heading_error", {{"k", k_, "rad/s"}}}; }
  void on_imu(const ImuMoment& moment, ImuReading& reading) const override;

 private:
  double k_;
};

/// White noise beside the sensors' own that grows with the rate, as what rattles does: standard deviation k times the
/// sensor's own for each rad/s.
class NoiseWithMotion : public Effect {
 public:
  NoiseWithMotion(double gyro, double accel) : gyro_(gyro), accel_(accel) {}
  EffectTruth truth() const override {
    return {"outside:noise_with_motion", {{"gyro", gyro_, "s/rad"}, {"accel", accel_, "s/rad"}}};
  }
  void on_log(Recording& recording, std::uint64_t seed) const override;

 private:
  double gyro_, accel_;
};

/// d += k |d - c|^6 (d - c) about an offset centre c on distorted normalised coordinates.
class DecentredDistortion : public Effect {
 public:
  DecentredDistortion(double k, double cx, double cy) : k_(k), centre_(cx, cy) {}
  EffectTruth truth() const override {
    return {"outside:decentred_distortion", {{"k", k_, "-"}, {"cx", centre_.x(), "-"}, {"cy", centre_.y(), "-"}}};
  }
  void on_pixel(const CameraCalibration& camera, double t, Eigen::Vector2d& pixel) const override;
  bool moves_pixels() const override { return true; }

 private:
  double k_;
  Eigen::Vector2d centre_;
};

}  // namespace host::sim
