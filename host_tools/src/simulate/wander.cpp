#include "wander.h"

#include <algorithm>
#include <cmath>

#include "angles.h"

namespace host::sim {
namespace {}  // namespace

Wander::Wander(Random& random, double rms, double f_low_Hz, double f_high_Hz, int n_sinusoids) {
  // A sinusoid of amplitude a has the root mean square a / sqrt(2).
  const double amplitude = rms * std::sqrt(2.0 / n_sinusoids);
  for (int i = 0; i < n_sinusoids; ++i) {
    const double share = (i + random.uniform()) / n_sinusoids;
    const double frequency_Hz = f_low_Hz + share * (f_high_Hz - f_low_Hz);
    sinusoids_.push_back({amplitude, two_pi * frequency_Hz, two_pi * random.uniform()});
  }
}

double Wander::operator()(double t) const {
  double sum = 0;
  for (const Sinusoid& s : sinusoids_) sum += s.amplitude * std::sin(s.rate * t + s.phase);
  return sum;
}

double smooth_step(double x) {
  const double c = std::clamp(x, 0.0, 1.0);
  return c * c * c * c * (35 - 84 * c + 70 * c * c - 20 * c * c * c);
}

void Envelope::set(double t, double level) { pieces_.push_back({t, level}); }

double Envelope::operator()(double t) const {
  double value = pieces_.empty() ? 0 : pieces_.front().level;
  double previous = value;
  for (const Piece& piece : pieces_) {
    if (piece.t > t) break;
    value += (piece.level - previous) * smooth_step((t - piece.t) / transition);
    previous = piece.level;
  }
  return value;
}

}  // namespace host::sim
