// Magnitudes: the accelerometer must show gravity, the gyroscope's noise tells its unit where no image turns.
#include <Eigen/Core>
#include <cmath>

#include "angles.h"
#include "diagnose/fault.h"
#include "diagnose/imu_noise.h"
#include "formatted.h"
#include "quantile.h"

namespace host {
namespace {

constexpr double gravity = 9.80665;  // m/s^2
// Uncalibrated sensors are within 1.2 % in scale and 0.05 m/s^2 in bias, one sigma each; gravity on Earth within 0.3 %.
constexpr double most_off_at_rest = 0.06;
constexpr double most_off_moving = 0.2;  // acceleration adds to the norm: 6 m/s^2 rms makes it 17 %
constexpr double most_off_unit = 0.25;   // a norm of 1 within this is g
constexpr double least_counts = 157;     // m/s^2, 16 g: no device is moved so for half of a recording
constexpr double stated_too_small = 3;   // noise that is stated so much too small is no unit

/// Mean of the norm of half-second means: shaking cancels within the mean, attitude does not change much.
struct Norms {
  double median = 0, at_rest = 0;  ///< at_rest: 0 where the device does not rest
  std::size_t n = 0;
};

Norms force_norms(const Recording& recording) {
  const std::vector<ImuSample>& samples = recording.imu.samples;
  const auto n = static_cast<std::size_t>(std::max(1.0, recording.imu.noise.rate_hz / 2));
  std::vector<double> all, rest;
  for (std::size_t begin = 0; begin + n <= samples.size(); begin += n) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero(), squares = Eigen::Vector3d::Zero();
    for (std::size_t k = begin; k < begin + n; ++k) {
      const Eigen::Vector3d f(samples[k].accel[0], samples[k].accel[1], samples[k].accel[2]);
      sum += f / static_cast<double>(n);
      squares += f.cwiseAbs2() / static_cast<double>(n);
    }
    const double scatter = std::sqrt(std::max(0.0, squares.sum() - sum.squaredNorm()));
    if (!std::isfinite(sum.norm())) continue;
    all.push_back(sum.norm());
    if (scatter < 0.02 * sum.norm()) rest.push_back(sum.norm());
  }
  return {quantile(all, 0.5), rest.size() >= 4 ? quantile(rest, 0.5) : 0, all.size()};
}

void check_gravity(const Recording& recording, std::vector<Fault>& out) {
  const Norms norms = force_norms(recording);
  if (norms.n < 4) return;
  const bool resting = norms.at_rest > 0;
  const double norm = resting ? norms.at_rest : norms.median, limit = resting ? most_off_at_rest : most_off_moving;
  if (std::abs(norm / gravity - 1) <= limit) return;
  Fault fault{"gravity_norm",
              "accel",
              recording.imu.samples.front().t_ns,
              recording.imu.samples.back().t_ns,
              recording.imu.samples.size(),
              norm,
              limit * gravity,
              "m/s^2",
              ""};
  if (std::abs(norm - 1) < most_off_unit) {
    fault.kind = "unit";
    fault.words = formatted(
        "accelerometer: readings have the size %.3f, which is g. Multiply by 9.80665: a recording has m/s^2.", norm);
  } else if (std::abs(norm / 1000 - 1) < most_off_unit) {
    fault.kind = "unit";
    fault.words = formatted(
        "accelerometer: readings have the size %.0f, which is mg (or raw counts of 1024 per g). Multiply by "
        "0.00980665: a recording has m/s^2.",
        norm);
  } else if (norm > least_counts) {
    fault.kind = "unit";
    fault.words = formatted(
        "accelerometer: readings have the size %.0f, which is raw counts. Multiply by what the data sheet says for the "
        "range that is set, here about 9.80665 / %.0f: a recording has m/s^2.",
        norm, norm);
  } else {
    fault.words = formatted("accelerometer: the specific force is %.2f m/s^2 ", norm) +
                  (resting ? "at rest" : "in the middle") +
                  formatted(", expected %.2f. Check the range setting and the scale factor of the driver.", gravity);
  }
  out.push_back(fault);
}

/// Noise of a gyroscope in deg/s is 57 times the stated one while the accelerometer's is as it should be. The image
/// says the same more surely where the device turns (rotation_faults), so this is for rest.
void check_gyro_unit(const Recording& recording, std::vector<Fault>& out) {
  const RawNoise noise = raw_imu_noise(recording);
  const double factor = noise.gyro.factor, least = deg_per_rad / stated_too_small;
  if (!noise.gyro.steady || factor < least || noise.accel.factor > 3) return;
  const char* const unit = factor < deg_per_rad * stated_too_small
                               ? "deg/s. Multiply by pi / 180"
                               : "mdeg/s or raw counts. Multiply by what the driver or the data sheet says";
  out.push_back(
      {"unit", "gyro", recording.imu.samples.front().t_ns, recording.imu.samples.back().t_ns,
       recording.imu.samples.size(), factor, least, "-",
       formatted("gyroscope: its noise is %.0f times the stated one, as of readings in %s: a recording has rad/s.",
                 factor, unit)});
}

}  // namespace

std::vector<Fault> magnitude_faults(const Recording& recording) {
  std::vector<Fault> out;
  if (recording.imu.samples.size() < 100) return out;
  check_gravity(recording, out);
  check_gyro_unit(recording, out);
  return out;
}

}  // namespace host
