// The scenario `arvr`: sessions with a headset or tablet in one room (the paper's AR/VR use case, Sec. VI).
//
// The paper: two minutes in a single room, "mostly fast rotations, only slow and minor translation and
// stationary phases"; means over its sessions 0.20 m/s and 20.3 deg/s (office room), 0.29 m/s and 29.6
// deg/s (class room). Here, over 120 s and seeds 1 to 10: 0.26 m/s and 26 deg/s (0.23 to 0.31, 22 to
// 32), 26 % of the time at rest, a box of 2 m x 2 m x 0.6 m. Those metres want nearly half of the time
// at half a metre per second, which is why strolling is the longest phase; the turning is in the bursts:
// over windows of 4 s the median rate is 18 deg/s, one in ten turns faster than 60, the fastest at 103.
// (`nav`, "only slow rotations" and nearly the same mean: median 21, one in ten faster than 31.)
#include "scenarios.h"
#include "wander.h"

namespace host::sim {
namespace {

/// What the user does: strolls and looks, turns the device about briskly, or holds still. One at a time.
struct Behaviour {
  Envelope stroll;  ///< pace along the slow paths, 1 is the pace at which they were drawn
  Envelope burst;   ///< size of the brisk turns, 1 is full
};

/// Phases of random length in random order, never the same twice in a row.
Behaviour draw_behaviour(Random& random, double t_begin, double t_end) {
  enum { strolling, bursting, still };
  Behaviour behaviour;
  int previous = -1;
  for (double t = t_begin; t < t_end;) {
    int phase = random.integer(strolling, still);
    if (phase == previous) phase = (phase + 1) % 3;
    const double slowest = phase == strolling ? 0.7 : 0.2, fastest = phase == strolling ? 1.2 : 0.5;
    behaviour.stroll.set(t, phase == still ? 0 : random.uniform(slowest, fastest));
    behaviour.burst.set(t, phase == bursting ? random.uniform(0.5, 1.0) : 0);
    t += phase == strolling ? random.uniform(5, 10) : random.uniform(3, 6.5);
    previous = phase;
  }
  return behaviour;
}

/// The slow paths through the room; the user looks mostly to the sides.
struct Stroll {
  Wander roll, pitch, yaw, x, y, z;
  explicit Stroll(Random& random)
      : roll(random, 0.05, 0.05, 0.3),
        pitch(random, 0.08, 0.05, 0.3),
        yaw(random, 0.50, 0.03, 0.15),
        x(random, 0.40, 0.04, 0.22),
        y(random, 0.40, 0.04, 0.22),
        z(random, 0.12, 0.04, 0.3) {}
  MotionSample at(double t) const { return {{x(t), y(t), z(t)}, {roll(t), -0.15 + pitch(t), yaw(t)}}; }
};

/// Brisk turns about all axes; the arms that make them move the device a little.
struct Burst {
  Wander roll, pitch, yaw, x, y, z;
  explicit Burst(Random& random)
      : roll(random, 0.35, 0.15, 0.6),
        pitch(random, 0.35, 0.15, 0.6),
        yaw(random, 0.60, 0.15, 0.5),
        x(random, 0.05, 0.2, 0.7),
        y(random, 0.05, 0.2, 0.7),
        z(random, 0.05, 0.2, 0.7) {}
  MotionSample at(double t) const { return {{x(t), y(t), z(t)}, {roll(t), pitch(t), yaw(t)}}; }
};

}  // namespace

std::vector<MotionSample> arvr_motion(std::uint64_t seed, double t0, double step, std::size_t n) {
  Random random(seed, Stream::motion);
  const Stroll stroll(random);
  const Burst burst(random);
  // Phases begin well before the recording, so that a session starts in motion or at rest as the seed has it.
  const double lead = 10;  // s
  const Behaviour behaviour = draw_behaviour(random, t0 - lead, t0 + step * static_cast<double>(n));

  constexpr int substeps = 10;
  double strolled = 0;  // time along the slow paths, s; it stands still when the pace is zero
  std::vector<MotionSample> samples(n);
  for (std::size_t k = 0; k < n; ++k) {
    const double t = t0 + step * static_cast<double>(k);
    const double size = behaviour.burst(t);
    const MotionSample slow = stroll.at(strolled), brisk = burst.at(t);
    samples[k].position = slow.position + size * brisk.position;
    samples[k].roll_pitch_yaw = slow.roll_pitch_yaw + size * brisk.roll_pitch_yaw;
    for (int i = 0; i < substeps; ++i) strolled += behaviour.stroll(t + step * (i + 0.5) / substeps) * step / substeps;
  }
  return samples;
}

}  // namespace host::sim
