// A calibration that stands although something is suspected says by how much that may move it.
#pragma once

#include <Eigen/Core>
#include <functional>

#include "replay/replay.h"

namespace host::review {

/// A movement d between two fits, one with an effect and one without, that has the sigma s by chance: d^2 is on average
/// bias^2 + s^2 (Hausman, "Specification tests in econometrics", Econometrica 46, 1978). Of d's sign, 0 where chance
/// explains it; s may be NaN where rounding makes a variance negative, and counts as 0.
double beyond_chance(double d, double s);

/// The largest of `moved`, which is by parameter and in its unit, in sigmas, of the released values that `counts`
/// accepts: the suspect's `bias_sigmas`, `moves` and `move`.
void find_largest(const std::vector<CoreParameter>& parameters, const Eigen::VectorXd& moved,
                  const std::function<bool(const CoreParameter&)>& counts, Suspect* out);

/// The certain one that moves a released value by most of its sigmas; null without any.
const Suspect* most_moving(const std::vector<Suspect>& suspects);

/// Is there an effect that explains more than a step, so that the step may be its work? `missing`: in their order.
bool explains_more(const std::vector<Suspect>& missing, const Suspect& step);

/// Sigmas and covariance with what a suspect would move, so that they hold whether it is right or not: sigma_i is at
/// least sqrt(n_i^2 + d_i^2), n being the noise's sigmas and d the suspect's `moved`. The larger counts, of this, of
/// how segments scatter (an effect makes them) and of other suspects (they explain the same residuals). The covariance
/// grows by e e', e being what is short in each. None exceeds its prior's; one above half of it is `weak`.
void widen_by(Suspect& suspect, ReplayResult* out);

}  // namespace host::review
