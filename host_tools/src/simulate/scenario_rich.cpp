// The scenario `rich`: somebody who wants to calibrate turns and shakes the device about every axis.
#include "scenarios.h"
#include "wander.h"

namespace host::sim {
namespace {

/// Slow and wide together with fast and narrow: the first reaches large tilts and distances, the second brings high
/// angular rates and accelerations.
class TwoBands {
 public:
  TwoBands(Random& random, double slow_rms, double fast_rms, double slow_high_Hz, double fast_low_Hz,
           double fast_high_Hz)
      : slow_(random, slow_rms, 0.06, slow_high_Hz), fast_(random, fast_rms, fast_low_Hz, fast_high_Hz) {}
  double operator()(double t) const { return slow_(t) + fast_(t); }

 private:
  Wander slow_, fast_;
};

TwoBands tilt(Random& random) { return {random, 0.55, 0.36, 0.22, 0.4, 0.9}; }
TwoBands heading(Random& random) { return {random, 1.0, 0.34, 0.18, 0.4, 0.9}; }
TwoBands place(Random& random) { return {random, 0.33, 0.09, 0.35, 0.7, 1.1}; }

}  // namespace

std::vector<MotionSample> rich_motion(std::uint64_t seed, double t0, double step, std::size_t n) {
  Random random(seed, Stream::motion);
  const TwoBands roll = tilt(random), pitch = tilt(random), yaw = heading(random);
  const TwoBands x = place(random), y = place(random), z = place(random);
  std::vector<MotionSample> samples(n);
  for (std::size_t k = 0; k < n; ++k) {
    const double t = t0 + step * static_cast<double>(k);
    samples[k].position = {x(t), y(t), z(t)};
    samples[k].roll_pitch_yaw = {roll(t), pitch(t), yaw(t)};
  }
  return samples;
}

}  // namespace host::sim
