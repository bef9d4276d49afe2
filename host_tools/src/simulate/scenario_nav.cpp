// The scenario `nav`: walking through several rooms with the device in the hand (the paper's navigation use case).
#include <cmath>

#include "angles.h"
#include "scenarios.h"
#include "wander.h"

namespace host::sim {
namespace {

/// Walking speed, heading of the path, and how much the person looks around, over time.
struct Walk {
  Envelope speed;    ///< m/s
  Envelope turning;  ///< rad/s, rate of the heading
  Envelope looking;  ///< pace of looking around, 1 is normal
};

/// Straight legs with a quarter turn or less at the end of each, and now and then a stop, some with a look around.
Walk draw_walk(Random& random, double t_begin, double t_end) {
  Walk walk;
  for (double t = t_begin; t < t_end;) {
    const double speed = random.uniform(0.65, 0.95);
    walk.speed.set(t, speed);
    walk.turning.set(t, 0);
    walk.looking.set(t, random.uniform(0.7, 1.2));
    t += random.uniform(5, 12);

    const double turn_seconds = random.uniform(2, 3);
    const double turn = (random.uniform() < 0.5 ? -1 : 1) * random.uniform(0.8, 1.7);  // rad
    walk.speed.set(t, 0.75 * speed);
    walk.turning.set(t, turn / turn_seconds);
    t += turn_seconds;
    walk.turning.set(t, 0);

    if (random.uniform() < 0.55) {
      walk.speed.set(t, 0);
      walk.looking.set(t, random.uniform() < 0.4 ? random.uniform(0.8, 1.5) : 0.0);
      t += random.uniform(3, 7);
    }
  }
  return walk;
}

struct Sway {
  Wander roll, pitch, look;
  explicit Sway(Random& random)
      : roll(random, 0.05, 0.15, 0.7), pitch(random, 0.09, 0.1, 0.5), look(random, 0.3, 0.06, 0.3) {}
};

}  // namespace

std::vector<MotionSample> nav_motion(std::uint64_t seed, double t0, double step, std::size_t n) {
  Random random(seed, Stream::motion);
  const Sway sway(random);
  const double lead = random.uniform(0, 10);  // s: a session may begin anywhere in the walk
  const Walk walk = draw_walk(random, t0 - lead, t0 + step * static_cast<double>(n));
  const double bob = 0.006, bob_Hz_per_speed = 2.2;  // m; steps per metre, so that the bob stops with the walker

  constexpr int substeps = 10;
  const double dt = step / substeps;
  double heading = random.uniform(-pi, pi), looked = 0, distance = 0;
  Eigen::Vector3d p = Eigen::Vector3d::Zero();
  std::vector<MotionSample> samples(n);
  for (std::size_t k = 0; k < n; ++k) {
    samples[k].position = p + Eigen::Vector3d(0, 0, bob * std::sin(2 * pi * bob_Hz_per_speed * distance));
    samples[k].roll_pitch_yaw = {sway.roll(looked), -0.1 + sway.pitch(looked), heading + sway.look(looked)};
    for (int i = 0; i < substeps; ++i) {
      const double t = t0 + step * static_cast<double>(k) + dt * (i + 0.5);
      const double speed = walk.speed(t);
      p += speed * dt * Eigen::Vector3d(std::cos(heading), std::sin(heading), 0);
      distance += speed * dt;
      heading += walk.turning(t) * dt;
      looked += walk.looking(t) * dt;
    }
  }
  return samples;
}

}  // namespace host::sim
