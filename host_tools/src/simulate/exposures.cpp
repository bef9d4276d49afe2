#include "exposures.h"

#include <cmath>

#include "../angles.h"
#include "random.h"

namespace host::sim {
namespace {

constexpr double shortest_s = 2e-3, longest_s = 20e-3;
constexpr double pull_rad = 1.5;  // a quarter of a turn to either side

}  // namespace

double after_stamp(const Effects& effects, double exposure_s) {
  double out = 0;
  for (const auto& effect : effects) out += effect->after_stamp(exposure_s);
  return out;
}

AutoExposure::AutoExposure(std::uint64_t seed) {
  Random random(seed, Stream::exposures);
  period_s_ = random.uniform(8, 16);
  pull_period_s_ = random.uniform(17, 31);
  phase_ = random.uniform(0, two_pi);
  pull_phase_ = random.uniform(0, two_pi);
}

double AutoExposure::at(double t) const {
  const double pull = pull_rad * std::sin(two_pi * t / pull_period_s_ + pull_phase_);
  const double place = 0.5 + 0.5 * std::sin(two_pi * t / period_s_ + phase_ + pull);
  return 1e-9 * std::round(1e9 * shortest_s * std::pow(longest_s / shortest_s, place));
}

}  // namespace host::sim
