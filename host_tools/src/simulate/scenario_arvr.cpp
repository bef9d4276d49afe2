// The scenario `arvr`: sessions with a headset or tablet in one room (the paper's AR/VR use case).
#include "scenarios.h"
#include "wander.h"

namespace host::sim {
namespace {

/// How fast the device turns and moves along its wandering paths; 1 is the pace at which the paths were drawn.
struct Pace {
  Envelope rotation, translation;
};

/// Bursts of rotation, slow walks around an object, and stillness follow each other in random order.
Pace draw_pace(Random& random, double t_begin, double t_end) {
  Pace pace;
  int previous = -1;
  for (double t = t_begin; t < t_end;) {
    int phase = random.integer(0, 2);
    if (phase == previous) phase = (phase + 1) % 3;
    const bool is_burst = phase == 0, is_still = phase == 2;
    pace.rotation.set(t, is_still ? 0 : is_burst ? random.uniform(1.0, 1.8) : random.uniform(0.3, 0.6));
    pace.translation.set(t, is_still ? 0 : is_burst ? random.uniform(0.4, 0.8) : random.uniform(1.0, 1.6));
    t += is_still ? random.uniform(3, 6.5) : random.uniform(4, 8.5);
    previous = phase;
  }
  return pace;
}

struct Paths {
  Wander roll, pitch, yaw, x, y, z;
  explicit Paths(Random& random)
      : roll(random, 0.11, 0.1, 0.5),
        pitch(random, 0.16, 0.1, 0.45),
        yaw(random, 0.60, 0.04, 0.32),
        x(random, 0.35, 0.04, 0.22),
        y(random, 0.35, 0.04, 0.22),
        z(random, 0.13, 0.04, 0.3) {}
};

}  // namespace

std::vector<MotionSample> arvr_motion(std::uint64_t seed, double t0, double step, std::size_t n) {
  Random random(seed, Stream::motion);
  const Paths paths(random);
  // Phases begin well before the recording, so that a session starts in motion or at rest as the seed has it.
  const double lead = 10;  // s
  const Pace pace = draw_pace(random, t0 - lead, t0 + step * static_cast<double>(n));

  constexpr int substeps = 10;
  double turned = 0, walked = 0;  // time along the two paths, s; it stands still when the pace is zero
  std::vector<MotionSample> samples(n);
  for (std::size_t k = 0; k < n; ++k) {
    samples[k].position = {paths.x(walked), paths.y(walked), paths.z(walked)};
    samples[k].roll_pitch_yaw = {paths.roll(turned), -0.15 + paths.pitch(turned), paths.yaw(turned)};
    for (int i = 0; i < substeps; ++i) {
      const double t = t0 + step * (static_cast<double>(k) + (i + 0.5) / substeps);
      turned += pace.rotation(t) * step / substeps;
      walked += pace.translation(t) * step / substeps;
    }
  }
  return samples;
}

}  // namespace host::sim
