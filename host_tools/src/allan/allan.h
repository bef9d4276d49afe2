// Noise of an IMU from a recording at rest: white noise and bias walk by the overlapping Allan deviation (IEEE Std
// 952-1997, annex C; Allan's own definition, Proc. IEEE 54, 1966).
#pragma once

#include <array>
#include <string>
#include <vector>

#include "diagnose/imu_noise.h"
#include "recording.h"

namespace host {

/// One axis: deviation^2 = density^2 / tau + instability^2 2 ln 2 / pi + walk^2 tau / 3.
struct AxisFit {
  double density = 0;      ///< rad/s/sqrt(Hz) or m/s^2/sqrt(Hz)
  double instability = 0;  ///< rad/s or m/s^2: the floor between the two slopes
  double walk = 0;         ///< rad/s^2/sqrt(Hz) or m/s^3/sqrt(Hz)
  double walk_sigma = 0;
  bool walk_seen = false;  ///< false: the rest is too short for it, `walk` is the most that the longest times allow
};

struct SensorFit {
  std::vector<AllanPoint> points;
  std::array<AxisFit, 3> axes;
  /// For a file with one number per sensor: the largest of the axes, of the seen walks where there are any.
  double density() const;
  double walk() const;
  bool walk_seen() const;
};

struct AllanResult {
  double rate_hz = 0, start_s = 0, rest_s = 0;  ///< the rest: start after the first sample, length
  SensorFit gyro, accel;
};

/// Shorter rests are refused: at 1 s of averaging 60 s give 60 values, and the density 4 % at best.
constexpr double least_rest_s = 60;

/// Fits the three terms to Allan deviations of one axis, each point weighted by how many averages it holds.
AxisFit fit_axis(const std::vector<AllanPoint>& points, std::size_t axis, double rest_s);

/// Over the longest rest. Throws NotAtRest with the cause where there is none of least_rest_s.
AllanResult allan_of(const std::vector<ImuSample>& samples);

/// The recording cannot answer; `what()` says why.
struct NotAtRest : std::runtime_error {
  using std::runtime_error::runtime_error;
};

}  // namespace host
