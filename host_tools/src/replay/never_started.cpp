#include "replay/never_started.h"

#include <algorithm>
#include <cmath>

#include "formatted.h"

namespace host {
namespace {

/// A device that turns in place has 0.999 and more with the noise of corners, walks along real paths 0.9 to 0.99.
constexpr double kAlike = 0.95;

/// m/s^2, root mean square of |a| about its mean: what accelerates by more, for a second, has gone half a metre.
constexpr double kLittle = 1;

double accelerates(const ImuData& imu) {
  double sum = 0, squares = 0;
  for (const ImuSample& s : imu.samples) {
    const double a = std::hypot(s.accel[0], s.accel[1], s.accel[2]);
    sum += a;
    squares += a * a;
  }
  const double n = std::max<double>(1, static_cast<double>(imu.samples.size()));
  return std::sqrt(std::max(0.0, squares / n - sum / n * (sum / n)));
}

}  // namespace

std::string turns_alike(const ClockSearch& clock, double moved_s) {
  if (!clock.judged || clock.differs_from(moved_s)) return "";
  return formatted(
      "images and gyroscope tell of the same turns at the stated offset (correlation %.2f), so that clocks, R_CI and "
      "the "
      "gyroscope's axes are right: look at the accelerometer (order and signs of its axes, m/s^2), at p_CI (in m), at "
      "the "
      "focal length, and for corners that do not belong to the scene",
      clock.correlation);
}

std::string never_started(const Counters& counters, const ClockSearch& clock, double moved_s, const ImuData& imu) {
  if (count_of(counters, "frames_used") > 0 || count_of(counters, "filter_restarts") > 0) return "";
  if (turns_alike(clock, moved_s).empty() || clock.correlation < kAlike) return "";
  if (accelerates(imu) > kLittle) return "";
  return formatted(
      "the odometry never started, although images and gyroscope turn alike (correlation %.3f): the device turns in "
      "place, or moves too little to tell how far anything is; move it by a hand's breadth and more about all axes. If "
      "it did, look at the accelerometer's axes and units, and at the focal length",
      clock.correlation);
}

}  // namespace host
