// Catalogue effects that are no mean of a reading: noise above what is stated, and a shock that moves the device.
#pragma once

#include "effect.h"

namespace host::sim {

/// The white noise is these factors times the stated one.
class NoiseFactor : public Effect {
 public:
  explicit NoiseFactor(const NoiseFactors& factors) : factors_(factors) {}
  EffectTruth truth() const override;
  void on_noise(NoiseFactors& factors) const override;
  bool needs_simulated_imu() const override { return factors_.gyro != 1 || factors_.accel != 1; }

 private:
  NoiseFactors factors_;
};

/// From time t on, s since the first frame, one block of the calibration is another.
/// Rotations: R <- Exp(step) R, rad; everything else: plus step. Blocks: cam0.r_CI,
/// cam0.p_CI, cam0.f, cam0.c, gyro.s, gyro.m, accel.s, accel.m, accel.r_AI.
class CalibrationShift : public Effect {
 public:
  /// Throws InputError for an unknown block or a wrong number of values.
  CalibrationShift(const std::string& block, double t, const std::vector<double>& step);
  EffectTruth truth() const override;
  void on_camera_calibration(const CameraMoment& moment, CameraCalibration& calibration) const override;
  void on_imu_calibration(double t, ImuCalibration& imu) const override;
  bool needs_simulated_imu() const override { return block_.rfind("cam", 0) != 0; }

 private:
  std::string block_;
  double t_;
  Eigen::Vector3d step_ = Eigen::Vector3d::Zero();  ///< two values for f and c
  std::string unit_;
};

}  // namespace host::sim
