#include "scenarios.h"

#include <cmath>

#include "../recording.h"
#include "angles.h"
#include "wander.h"

namespace host::sim {
namespace {

constexpr double sample_step = 0.1;  // s; motion content is below 2 Hz
constexpr double margin = 1;         // s before the first and after the last frame

/// Attitude of a device that rests somewhere: upright within a few degrees, any heading.
Eigen::Vector3d resting_attitude(Random& random) {
  const double roll = 0.05 * random.normal(), pitch = 0.05 * random.normal();
  return {roll, pitch, random.uniform(-pi, pi)};
}

}  // namespace

std::vector<MotionSample> still_motion(std::uint64_t seed, double, double, std::size_t n) {
  Random random(seed, Stream::motion);
  MotionSample rest;
  rest.roll_pitch_yaw = resting_attitude(random);
  return std::vector<MotionSample>(n, rest);
}

std::vector<MotionSample> rotation_motion(std::uint64_t seed, double t0, double step, std::size_t n) {
  Random random(seed, Stream::motion);
  const Wander roll(random, 0.45, 0.1, 0.6), pitch(random, 0.35, 0.1, 0.6), yaw(random, 0.9, 0.05, 0.4);
  std::vector<MotionSample> samples(n);
  for (std::size_t k = 0; k < n; ++k) {
    const double t = t0 + step * static_cast<double>(k);
    samples[k].roll_pitch_yaw = {roll(t), pitch(t), yaw(t)};
  }
  return samples;
}

std::vector<MotionSample> line_motion(std::uint64_t seed, double t0, double step, std::size_t n) {
  Random random(seed, Stream::motion);
  const double speed = 0.6;  // m/s
  MotionSample sample;
  sample.roll_pitch_yaw = resting_attitude(random);
  const double course = sample.roll_pitch_yaw.z() + random.uniform(-0.6, 0.6);
  std::vector<MotionSample> samples(n, sample);
  for (std::size_t k = 0; k < n; ++k) {
    const double distance = speed * (t0 + step * static_cast<double>(k));
    samples[k].position = distance * Eigen::Vector3d(std::cos(course), std::sin(course), 0);
  }
  return samples;
}

std::vector<MotionSample> planar_motion(std::uint64_t seed, double t0, double step, std::size_t n) {
  Random random(seed, Stream::motion);
  const Wander x(random, 0.5, 0.05, 0.35), y(random, 0.5, 0.05, 0.35), yaw(random, 0.9, 0.05, 0.35);
  std::vector<MotionSample> samples(n);
  for (std::size_t k = 0; k < n; ++k) {
    const double t = t0 + step * static_cast<double>(k);
    samples[k].position = {x(t), y(t), 0};
    samples[k].roll_pitch_yaw = {0, 0, yaw(t)};
  }
  return samples;
}

const std::vector<Scenario>& scenarios() {
  static const std::vector<Scenario> all = {
      {"arvr", "a headset or tablet in one room: bursts of rotation, little and slow translation, stillness",
       arvr_motion},
      {"nav", "walking through several rooms at about 0.55 m/s: turns, stops, looking around", nav_motion},
      {"rich", "shaken by hand on purpose: strong rotation and acceleration about and along all axes", rich_motion},
      {"still", "at rest (degenerate: almost nothing is observable)", still_motion},
      {"rotation", "rotation in place about the IMU (degenerate: no parallax)", rotation_motion},
      {"line", "a straight line at constant speed and attitude (degenerate)", line_motion},
      {"planar", "motion in a horizontal plane with yaw only (degenerate)", planar_motion},
  };
  return all;
}

Trajectory make_trajectory(const std::string& scenario, double seconds, std::uint64_t seed) {
  for (const Scenario& candidate : scenarios()) {
    if (scenario != candidate.name) continue;
    // The spline can be evaluated two steps after its first and three before its last sample.
    const double t0 = -margin - 2 * sample_step;
    const auto n = static_cast<std::size_t>(std::ceil((seconds + 2 * margin) / sample_step)) + 7;
    return Trajectory(t0, sample_step, candidate.generate(seed, t0, sample_step, n));
  }
  throw InputError("unknown scenario '" + scenario + "'");
}

}  // namespace host::sim
