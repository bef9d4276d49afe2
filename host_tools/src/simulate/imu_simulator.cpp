#include "imu_simulator.h"

#include <algorithm>
#include <cmath>

namespace host::sim {
namespace {

constexpr double initial_gyro_bias_sigma = 0.005;  // rad/s
constexpr double initial_accel_bias_sigma = 0.05;  // m/s^2

}  // namespace

BiasHistory::BiasHistory(std::uint64_t seed, const ImuNoise& noise, double t0, std::size_t n)
    : t0_(t0), step_(1 / noise.rate_hz), values_(n) {
  Random random(seed, Stream::biases);
  const double gyro_step = noise.gyro_random_walk * std::sqrt(step_);
  const double accel_step = noise.accel_random_walk * std::sqrt(step_);
  Biases biases{random.normal3(initial_gyro_bias_sigma), random.normal3(initial_accel_bias_sigma)};
  for (Biases& value : values_) {
    value = biases;
    biases.gyro += random.normal3(gyro_step);
    biases.accel += random.normal3(accel_step);
  }
}

Biases BiasHistory::at(double t) const {
  if (values_.empty()) return {};
  const double s = std::clamp((t - t0_) / step_, 0.0, static_cast<double>(values_.size() - 1));
  const auto before = static_cast<std::size_t>(s);
  const std::size_t after = std::min(before + 1, values_.size() - 1);
  const double share = s - static_cast<double>(before);
  return {values_[before].gyro + share * (values_[after].gyro - values_[before].gyro),
          values_[before].accel + share * (values_[after].accel - values_[before].accel)};
}

ImuReading ideal_reading(const ImuCalibration& unshaken, const Trajectory& truth, double t, const Effects& effects,
                         double temperature_degC) {
  ImuCalibration imu = unshaken;
  for (const auto& effect : effects) effect->on_imu_calibration(t, imu);
  const BodyState state = truth.at(t);
  const Eigen::Vector3d specific_force_I = state.R_GI.transpose() * (state.a_GI - gravity_G);
  ImuReading reading{imu.T_g * state.w_GI, imu.T_a * imu.R_AI * specific_force_I};
  const ImuMoment moment{t, truth, imu, state, specific_force_I, temperature_degC};
  for (const auto& effect : effects) effect->on_imu(moment, reading);
  return reading;
}

ImuWhiteNoise::ImuWhiteNoise(std::uint64_t seed, const ImuNoise& noise, const NoiseFactors& factors)
    : random_(seed, Stream::imu),
      gyro_sigma_(factors.gyro * noise.gyro_noise_density * std::sqrt(noise.rate_hz)),
      accel_sigma_(factors.accel * noise.accel_noise_density * std::sqrt(noise.rate_hz)) {}

void ImuWhiteNoise::add_to(ImuReading& reading) {
  reading.gyro += random_.normal3(gyro_sigma_);
  reading.accel += random_.normal3(accel_sigma_);
}

}  // namespace host::sim
