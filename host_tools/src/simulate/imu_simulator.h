// What the IMU measures along a true motion: w_m = T_g w + b_g + n_g, a_m = T_a R_AI R_IG (a_G - g) + b_a + n_a.
#pragma once

#include <cstdint>
#include <vector>

#include "../calibration_file.h"
#include "effect.h"
#include "random.h"
#include "temperature.h"

namespace host::sim {

/// Gravity vector in G, m/s^2.
inline const Eigen::Vector3d gravity_G(0, 0, -9.80665);

struct Biases {
  Eigen::Vector3d gyro = Eigen::Vector3d::Zero();   ///< rad/s
  Eigen::Vector3d accel = Eigen::Vector3d::Zero();  ///< m/s^2
};

/// Random walks, sampled at the IMU's rate and linear in between.
class BiasHistory {
 public:
  BiasHistory() = default;
  /// Starts at N(0, 0.005 rad/s) and N(0, 0.05 m/s^2) per axis; `n` values from `t0`, s, on.
  BiasHistory(std::uint64_t seed, const ImuNoise& noise, double t0, std::size_t n);
  /// Clamped to the span of the history; zero for an empty one.
  Biases at(double t) const;
  const std::vector<Biases>& values() const { return values_; }

 private:
  double t0_ = 0, step_ = 1;
  std::vector<Biases> values_;
};

/// The reading without bias and noise at time t, s.
ImuReading ideal_reading(const ImuCalibration& imu, const Trajectory& truth, double t, const Effects& effects,
                         double temperature_degC = reference_temperature_degC);

/// White noise of one sample has the standard deviation density * sqrt(rate), times the factor of the effects.
class ImuWhiteNoise {
 public:
  ImuWhiteNoise(std::uint64_t seed, const ImuNoise& noise, const NoiseFactors& factors = {});
  void add_to(ImuReading& reading);

 private:
  Random random_;
  double gyro_sigma_, accel_sigma_;  ///< rad/s, m/s^2
};

}  // namespace host::sim
