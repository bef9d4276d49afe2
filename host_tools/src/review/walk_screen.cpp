#include "review/walk_screen.h"

#include <algorithm>
#include <cmath>

#include "reference/link_noise.h"

namespace host::review {
namespace {

/// Of 30 recordings without a step 27 are below, and 2.0 is the largest; of steps that
/// made an answer wrong by 5 sigmas the smallest had 2.5. The test's own z is 2 to 20
/// times as large: images hold attitude and place loosely where corners are few.
constexpr double kScreen = 1.8;

/// Of one sensor, per state: the walk's variance since the one before
/// (0: none), and what the link that begins there says of the bias.
struct Smoother {
  std::vector<double> walk, information;

  explicit Smoother(std::size_t states) : walk(states, 0), information(states, 0) {}

  /// The largest |step| over the sigma of what both sides say of it; `step(k)`: from state k - 1 to k.
  template <class Step>
  double largest(const Step& step) const {
    const std::size_t n = walk.size();
    std::vector<double> before(n), after(n);
    const auto carried = [](double known, double variance) {
      return known > 0 && variance > 0 ? 1 / (1 / known + variance) : 0;
    };
    for (std::size_t k = 0; k < n; ++k) before[k] = information[k] + (k > 0 ? carried(before[k - 1], walk[k]) : 0);
    for (std::size_t k = n; k-- > 0;) after[k] = information[k] + (k + 1 < n ? carried(after[k + 1], walk[k + 1]) : 0);
    double out = 0;
    for (std::size_t k = 1; k < n; ++k) {
      if (!(walk[k] > 0 && before[k - 1] > 0 && after[k] > 0)) continue;
      out = std::max(out, std::abs(step(k)) / walk[k] * std::sqrt(walk[k] + 1 / before[k - 1] + 1 / after[k]));
    }
    return out;
  }
};

}  // namespace

bool may_step(const reference::Problem& problem) {
  const CoreModel& model = problem.model;
  const std::vector<reference::State>& states = problem.states;
  Smoother gyro(states.size()), accel(states.size());
  const auto walks = [&](int to, double dt_s) {
    gyro.walk[static_cast<std::size_t>(to)] = model.gyro_random_walk * model.gyro_random_walk * dt_s;
    accel.walk[static_cast<std::size_t>(to)] = model.accel_random_walk * model.accel_random_walk * dt_s;
  };
  for (const reference::Link& l : problem.links) {
    const auto from = static_cast<std::size_t>(l.from);
    const std::int64_t t0_ns = states[from].t_ns, t1_ns = states[static_cast<std::size_t>(l.to)].t_ns;
    const double dt_s = 1e-9 * static_cast<double>(t1_ns - t0_ns);
    const reference::LinkNoise white =
        reference::link_noise(model, problem.samples[static_cast<std::size_t>(l.samples)], t0_ns, t1_ns);
    gyro.information[from] = dt_s / (white.gyro * white.gyro);
    accel.information[from] = dt_s / (white.accel * white.accel);
    walks(l.to, dt_s);
  }
  for (const reference::BiasWalk& w : problem.walks) walks(w.to, w.gap_s);
  double largest = 0;
  for (int axis = 0; axis < 3; ++axis) {
    largest =
        std::max(largest, gyro.largest([&](std::size_t k) { return states[k].b_g(axis) - states[k - 1].b_g(axis); }));
    largest =
        std::max(largest, accel.largest([&](std::size_t k) { return states[k].b_a(axis) - states[k - 1].b_a(axis); }));
  }
  return largest > kScreen;
}

}  // namespace host::review
