// How much of the disagreement between model and measurements do
// the named effects remove, on data that they were not fitted to?
//
// Each half k of the recording (selection.h) is held against effects c_j from the other half j. In both halves theta is
// free: it is a nuisance like the states, and what is left, R_k c = d_k with d_k = R_k c_true + e, e ~ N(0, noise I),
// is about the effects alone. The change that the trained effects predict is v = R_k c_j. Along v,
//     before = (v'd)^2 / |v|^2 - noise,                                  the excess of a model without effects,
//     after  = (v'(d - v))^2 / |v|^2 - noise (1 + v'R_k Sigma_j R_k'v / |v|^2),   the excess with them.
// Both are zero in expectation if nothing is there: the first terms hold one degree of freedom of noise, and `after`
// the training's uncertainty as the held-out rows see it. Along v and not over all parameters of the effects: with m of
// them the noise of `after` would be sqrt(m) times larger, and with a statistic of 60 and m = 9 the share that is
// closed would be good to 30 % only. What is left across v shows in test_halves and in the rest below. With one
// direction and a statistic of s over both halves, `after` scatters by sqrt(2) (1 + 1) per half, 5.7 together: an
// excess below two such sigmas counts as none.
//
// The rest is what no named effect explains: chi2 of the held-out halves over what noise leaves in them, or what
// the cost falls by with the candidate that was not accepted and says most, if that is more. All of these are in chi2
// of the stated noise, not divided by the dispersion, so that they compare.
#pragma once

#include <algorithm>

#include "diagnose/decision.h"
#include "diagnose/selection.h"

namespace host::diagnosis {

struct Gap {
  double dof = 0;                ///< of the held-out rows, both halves
  double before = 0, after = 0;  ///< excess of chi2 in the held-out rows, along what was predicted, and the rest
  double after_measured = 0;     ///< before counting as none what is within its noise; without the rest
  double after_sigma = 0;
  double rest = 0;
  double floor = 1;  ///< chi2/dof that is left where the model is right
  /// Share of the gap that is closed.
  double closed() const { return before > 0 ? 1 - after / before : 0; }
  /// The same where what is left along the prediction counts only if chance would not have left it: for a name. At a
  /// statistic of 100 the halves differ by 2.6 of their sigmas in one recording of a hundred, and a tenth is left.
  double closed_but_for_chance() const {
    const double left = after_measured - decision::kChanceLeaves * after_sigma;
    return before > 0 ? 1 - (std::max(0.0, left) + rest) / before : 0;
  }
};

/// chi2/dof that noise leaves, as it was measured apart from the fit.
struct Floor {
  double value = 1, sigma = 0;
};

/// `rest_chi2`: what the cost falls by where that which was not accepted is free.
Gap held_out_gap(const Problem& problem, const std::vector<Candidate>& candidates,
                 const std::vector<Accepted>& accepted, const Floor& floor, double rest_chi2);

/// Effects as a set of segments tells them, theta free.
struct Trained {
  std::vector<TermGroup> groups;  ///< columns of the effects, in the order of their entries
  Eigen::VectorXd value;
  Eigen::MatrixXd covariance;  ///< scaled by the dispersion
};
Trained trained_on(const Problem& training, const std::vector<Candidate>& candidates,
                   const std::vector<Accepted>& accepted);

/// Effects that were chosen and fitted on `training` against the rows of `held_out`, segments of the same recording.
Gap fold_gap(const Problem& training, const Problem& held_out, const std::vector<Candidate>& candidates,
             const std::vector<Accepted>& accepted);

/// The same for one of the accepted effects, the others free.
Gap held_out_gap_of(const Problem& problem, const std::vector<Candidate>& candidates,
                    const std::vector<Accepted>& accepted, std::size_t which);

}  // namespace host::diagnosis
