// White noise of an IMU from its raw samples, without any model of the motion, against
// what sensor.yaml states. A fit over keyframes cannot tell it: between two keyframes
// a hundred samples are summed, and the model's own noise hides in the rest.
//
// Assumed: the noise is white from a fifth of the rate up to nearly half of it, the band that is
// looked at; motion of a hand, a head or a vehicle stays below it for some of the time;
// quantisation is part of the noise (its variance quantum^2 / 12 is). A sensor that filters within
// the band seems quieter than it is; the Allan deviation, where the device rests for eight seconds,
// does not have that fault. Vibration of rotors fills the band: it comes and goes, noise does not.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "recording.h"

namespace host {

/// One axis. Densities in rad/s/sqrt(Hz) or m/s^2/sqrt(Hz).
struct AxisNoise {
  double density = 0, sigma = 0;  ///< spectrum of the quietest quarter of the windows
  double median_density = 0;  ///< the same over all windows: above `density` where motion or vibration fills the band
  double allan_density = 0;   ///< from rest, at 0.1 to 0.5 s; 0 where the device does not rest long enough
};

struct AllanPoint {
  double tau_s;
  std::array<double, 3> deviation;  ///< rad/s, m/s^2
};

struct SensorNoise {
  enum class Verdict { as_stated, above, below, cannot_tell };
  std::array<AxisNoise, 3> axes;
  double stated = 0;             ///< density of sensor.yaml
  double factor = 1, sigma = 0;  ///< density over the stated one, root mean square of the axes
  bool steady = false;           ///< false: the band holds motion that comes and goes, `factor` is an upper bound
  double lively_factor = 0;      ///< the same over the quarter of the windows that shakes most; 0: too few samples
  bool grows = false;            ///< with motion: `lively_factor` is well above `factor`, and alike at all frequencies
  Verdict verdict = Verdict::cannot_tell;
  std::vector<AllanPoint> allan;  ///< empty where the device does not rest long enough
  std::string words;              ///< one sentence
};

struct RawNoise {
  SensorNoise gyro, accel;
  double rest_s = 0;  ///< the longest rest
};

/// A factor above this says imu_noise, three sigmas included: sensors scatter by half around their data sheets, and
/// at 1.6 sigmas of what the IMU tells are 1.6 times too small.
constexpr double noise_factor_high = 1.6;
/// Below this the sensor is said to be better than stated; no fault: stating ten times the noise is a habit of many,
/// and a filter inside the sensor looks the same.
constexpr double noise_factor_low = 0.3;

/// Power that falls to less than this from the lower half of the band to the upper one is motion: a sensor's reading of
/// it falls with the fourth power of the frequency and more, a fifth; what rattles beside it is alike at both.
constexpr double least_whiteness = 0.5;

/// Over the samples within the span of the cameras' frames (all samples where there are none).
RawNoise raw_imu_noise(const Recording& recording);

}  // namespace host
