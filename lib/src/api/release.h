// What of a calibration is released: a verdict per parameter,
// and the values that go with it (docs/design.md, section 9).
//
// A parameter whose sigma did not fall clearly below the prior's is not guessed: it goes back to where it was, and the
// others move to their best values given that.
#pragma once

#include "api/printed_value.h"
#include "calibration/calibrator.h"
#include "information/marginal.h"
#include "information/metrics.h"
#include "information/release_rules.h"
#include "math/small_solvers.h"

namespace SEGCAL_NS {

enum class Verdict : std::int32_t { fixed = 0, weak = 1, observed = 2 };
enum class Status : std::int32_t { insufficient = 0, calibrated = 1, failed = 2 };

template <class S>
struct Release {
  Status status = Status::insufficient;
  Calibration<S> theta;
  S sigma[kMaxTheta];          ///< of theta's columns (rotations: small rotations)
  S printed_sigma[kMaxTheta];  ///< of the values as printed (rotations: components of the rotation vector)
  Verdict verdict[kMaxTheta];
  S noise_scale = S(1);
};

/// Puts the fixed components of all rotation vectors to the prior's, exactly: a step does so to first order only.
template <class S>
void restore_fixed_components(const Calibration<S>& mean, const Verdict* verdict, Calibration<S>* theta) {
  for (int i = 0; i < theta->columns(); ++i) {
    int first;
    Mat3<S>* R = rotation_of(theta, i, &first);
    if (!R || i != first) continue;
    if (verdict[i] != Verdict::fixed && verdict[i + 1] != Verdict::fixed && verdict[i + 2] != Verdict::fixed) continue;
    const Mat3<S>& R_mean = *rotation_of(&mean, i, &first);
    const Vec3<S> v_mean = so3_log<S>(R_mean);
    Vec3<S> v = so3_log_near<S>(*R, v_mean);
    int fixed = 0;
    for (int k = 0; k < 3; ++k) {
      if (verdict[i + k] != Verdict::fixed) continue;
      v(k) = v_mean(k);
      ++fixed;
    }
    *R = fixed == 3 ? R_mean : so3_exp<S>(v);
  }
}

/// Index of the fixed value that is least known, of those not yet `done`; -1 if none is left.
template <class S>
int least_known(const Release<S>& release, const ThetaPrior<S>& prior, const bool* done) {
  int least = -1;
  S largest = S(0);
  for (int i = 0; i < release.theta.columns(); ++i) {
    if (done[i] || release.verdict[i] != Verdict::fixed) continue;
    const S relative =
        release.printed_sigma[i] / sigma_before(printed_value(prior.mean, release.theta, i), prior.sigma);
    if (least >= 0 && !(relative > largest)) continue;
    least = i;
    largest = relative;
  }
  return least;
}

/// How far a printed value is from `offset` (both from theta), in its own sigmas, given all that is held already.
template <class S>
S distance_in_sigmas(const PackedTriangle<S>& R, int n, const PrintedValue<S>& value, S offset, S noise_scale) {
  S x[kMaxTheta], work[kMaxTheta + 1];
  for (int i = 0; i < n; ++i) x[i] = R(i, n);
  back_substitute(R, n, x);
  S at = S(0);
  for (int k = 0; k < value.count; ++k) at += value.weight[k] * x[value.first + k];
  return absolute(at - offset) / (marginal_sigma(R, n, value.first, value.weight, value.count, work) * noise_scale);
}

/// One row far above what the data say, well inside float.
template <class S>
void hold(PackedTriangle<S>* R, int n, const PrintedValue<S>& value, S offset, S prior_sigma) {
  const S weight = S(1e4) / prior_sigma;
  S row[kMaxTheta + 1];
  for (int c = 0; c < n; ++c) row[c] = S(0);
  for (int k = 0; k < value.count; ++k) row[value.first + k] = weight * value.weight[k];
  row[n] = weight * offset;
  fold_rows(*R, row, 1, n + 1, value.first, n + 1);
}

/// Moves theta so that the fixed values stand at the prior's mean and the rest is optimal given that. Values that
/// nothing tells one by one may be well known together: the least known are held first, and one that then would
/// contradict the data by more than three sigmas is let go as weak, since holding it would push the others away from
/// where they belong. `R`: triangle over [theta | rhs] at `theta`, rhs near zero at the optimum; it is changed.
template <class S>
[[gnu::cold]] void hold_fixed(const ThetaPrior<S>& prior, PackedTriangle<S>* R, Release<S>* out) {
  const int n = out->theta.columns();
  S offset[kMaxTheta];
  bool done[kMaxTheta] = {};
  difference(out->theta, prior.mean, offset);
  for (int i = least_known(*out, prior, done); i >= 0; i = least_known(*out, prior, done)) {
    const PrintedValue<S> value = printed_value(prior.mean, out->theta, i);
    S to_mean = S(0);
    for (int k = 0; k < value.count; ++k) to_mean += value.weight[k] * offset[value.first + k];
    done[i] = true;
    if (distance_in_sigmas(*R, n, value, to_mean, out->noise_scale) > S(3)) {
      out->verdict[i] = Verdict::weak;
    } else {
      hold(R, n, value, to_mean, prior.sigma[i]);
    }
  }
  S step[kMaxTheta];
  for (int i = 0; i < n; ++i) step[i] = (*R)(i, n);
  back_substitute(*R, n, step);
  for (int i = 0; i < n; ++i) {
    if (out->verdict[i] == Verdict::fixed && printed_value(prior.mean, out->theta, i).count == 1) step[i] = offset[i];
  }
  add_step(&out->theta, step);
  restore_fixed_components(prior.mean, out->verdict, &out->theta);
}

/// Verdicts and sigmas from the triangle over [theta | rhs]; returns how many parameters are observed.
template <class S>
int judge_parameters(const PackedTriangle<S>& R, const Calibration<S>& theta, const ThetaPrior<S>& prior,
                     const ReleaseRules<S>& rules, Release<S>* out) {
  const int n = theta.columns();
  S work[kMaxTheta + 1];
  int observed = 0;
  for (int i = 0; i < n; ++i) {
    const S one = S(1);
    const S sigma = marginal_sigma(R, n, i, &one, 1, work) * out->noise_scale;
    out->sigma[i] = sigma < prior.sigma[i] ? sigma : prior.sigma[i];
    const PrintedValue<S> value = printed_value(prior.mean, theta, i);
    const S before = sigma_before(value, prior.sigma);
    const S after = marginal_sigma(R, n, value.first, value.weight, value.count, work) * out->noise_scale;
    out->printed_sigma[i] = after < before ? after : before;
    const S relative = out->printed_sigma[i] / before;
    out->verdict[i] = relative < rules.observed ? Verdict::observed
                      : relative < rules.weak   ? Verdict::weak
                                                : Verdict::fixed;
    observed += out->verdict[i] == Verdict::observed ? 1 : 0;
  }
  return observed;
}

/// Verdicts, sigmas and status from the finished fit. `scatter`: variance of what segments say, in units of stated
/// noise; 0 if not known. Sigmas are for the largest of that, of what residuals show, and of the stated noise.
template <class S>
void judge(Calibrator<S>* calibrator, const ThetaPrior<S>& prior, const ReleaseRules<S>& rules, S scatter,
           Release<S>* out) {
  PackedTriangle<S> R = calibrator->theta_triangle();
  const CalibrationFit<S>& fit = calibrator->fit();
  const int n = calibrator->theta().columns();
  const S ratio = fit.dof > S(0) ? fit.chi2 / fit.dof : S(0);
  const S variance = scatter > ratio ? scatter : ratio;
  out->noise_scale = variance > S(1) ? square_root(variance) : S(1);
  const int observed = judge_parameters(R, calibrator->theta(), prior, rules, out);
  const bool plausible = ratio > rules.least_chi2_per_dof && ratio < rules.most_chi2_per_dof;
  // a fit that begins at its minimum may round up
  const bool fell = fit.cost <= fit.start_cost * S(1.0001) && is_finite(fit.cost);
  out->theta = calibrator->theta();
  if (fit.image_points == 0) {
    out->status = Status::insufficient;
  } else if (!plausible || !fell || !fit.converged) {
    out->status = Status::failed;
  } else {
    out->status = 2 * observed >= n ? Status::calibrated : Status::insufficient;
  }
  if (out->status == Status::failed) {
    out->theta = prior.mean;
    for (int i = 0; i < n; ++i) out->verdict[i] = Verdict::fixed;
  } else {
    hold_fixed(prior, &R, out);
  }
}

/// The same of the filter's own calibration: `R` over theta's columns with a right-hand side of zero; it is changed.
/// The filter has paid for its residuals in its weights, so that nothing is left to scale.
template <class S>
void judge_filter(const Calibration<S>& theta, const ThetaPrior<S>& prior, const ReleaseRules<S>& rules,
                  PackedTriangle<S>* R, Release<S>* out) {
  out->theta = theta;
  out->noise_scale = S(1);
  const int observed = judge_parameters(*R, theta, prior, rules, out);
  out->status = 2 * observed >= theta.columns() ? Status::calibrated : Status::insufficient;
  hold_fixed(prior, R, out);
}

/// A filter that has not started knows the prior.
template <class S>
void release_prior(const ThetaPrior<S>& prior, Release<S>* out) {
  out->theta = prior.mean;
  out->status = Status::insufficient;
  out->noise_scale = S(1);
  for (int i = 0; i < prior.mean.columns(); ++i) {
    out->sigma[i] = out->printed_sigma[i] = prior.sigma[i];
    out->verdict[i] = Verdict::fixed;
  }
}

}  // namespace SEGCAL_NS
