// Building blocks of the scenarios: wandering signals, and a clock that runs, slows down and stops.
#pragma once

#include <vector>

#include "random.h"

namespace host::sim {

/// A sum of sinusoids with random frequencies and phases: smooth, bounded, zero mean, of the given root mean square.
class Wander {
 public:
  /// Frequencies are drawn evenly spread over [f_low, f_high], Hz.
  Wander(Random& random, double rms, double f_low_Hz, double f_high_Hz, int n_sinusoids = 5);
  double operator()(double t) const;

 private:
  struct Sinusoid {
    double amplitude, rate, phase;  ///< signal's unit, rad/s, rad
  };
  std::vector<Sinusoid> sinusoids_;
};

/// From 0 at x <= 0 to 1 at x >= 1, three continuous derivatives.
double smooth_step(double x);

/// A piecewise constant level with smooth changes between the pieces.
class Envelope {
 public:
  /// The level holds from `t`, s, on, reached `transition` seconds later. Calls in order of time.
  void set(double t, double level);
  double operator()(double t) const;
  /// How long a change of level takes, s.
  static constexpr double transition = 0.8;

 private:
  struct Piece {
    double t, level;
  };
  std::vector<Piece> pieces_;
};

}  // namespace host::sim
