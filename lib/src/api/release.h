// What of a calibration is released: a verdict per parameter, and the values that go with it (DESIGN, section 4).
//
// A parameter whose sigma did not fall clearly below the prior's is not guessed: it goes back to where it was, and the
// others move to their best values given that.
#pragma once

#include "calibration/calibrator.h"
#include "information/marginal.h"
#include "information/metrics.h"

namespace SEGCAL_NS {

enum class Verdict : std::int32_t { fixed = 0, weak = 1, observed = 2 };
enum class Status : std::int32_t { insufficient = 0, calibrated = 1, failed = 2 };

/// Thresholds on sigma / prior sigma, and on chi2/dof.
template <class S>
struct ReleaseRules {
  S observed = S(0.3), weak = S(0.8);
  S least_chi2_per_dof = S(0.2), most_chi2_per_dof = S(6);
};

template <class S>
struct Release {
  Status status = Status::insufficient;
  Calibration<S> theta;
  S sigma[kMaxTheta];          ///< of theta's columns (rotations: small rotations)
  S printed_sigma[kMaxTheta];  ///< of the values as printed (rotations: components of the rotation vector)
  Verdict verdict[kMaxTheta];
  S noise_scale = S(1);
};

/// Sigmas of a rotation's three printed numbers, the rotation vector's components. Theta's columns are the small rotation
/// Exp(d) R; Log(Exp(d) R) moves by J_l^-1(Log R) d.
template <class S>
void rotation_vector_sigmas(const PackedTriangle<S>& R, int n, int first, const Mat3<S>& rotation, S* out, S* work) {
  const Mat3<S> J = so3_right_jacobian_inverse<S>(Vec3<S>(-so3_log<S>(rotation)));  // left is right of the negative
  for (int i = 0; i < 3; ++i) {
    const S row[3] = {J(i, 0), J(i, 1), J(i, 2)};
    out[i] = marginal_sigma(R, n, first, row, 3, work);
  }
}

/// Sigmas as printed beside the values: those of theta's columns, and of the rotation vectors where a value is one.
template <class S>
void printed_sigmas(const PackedTriangle<S>& R, const Calibration<S>& theta, S scale, const S* column_sigma, S* out, S* work) {
  const int n = theta.columns();
  for (int i = 0; i < n; ++i) out[i] = column_sigma[i];
  const auto rotation = [&](int first, const Mat3<S>& matrix) {
    rotation_vector_sigmas(R, n, first, matrix, out + first, work);
    for (int i = 0; i < 3; ++i) out[first + i] *= scale;
  };
  for (int c = 0; c < theta.n_cameras; ++c) rotation(theta.camera_column(c), theta.camera[c].R_CI);
  rotation(n - 3, theta.imu.R_AI);
}

/// Moves theta so that the fixed entries stand at the prior's mean and the rest is optimal given that.
/// `R`: triangle over [theta | rhs] at `theta`, rhs near zero at the optimum; it is changed.
template <class S>
void hold_fixed(const ThetaPrior<S>& prior, const Verdict* verdict, PackedTriangle<S>* R, Calibration<S>* theta) {
  const int n = theta->columns();
  S offset[kMaxTheta], row[kMaxTheta + 1];
  difference(prior.mean, *theta, offset);
  for (int i = 0; i < n; ++i) {
    if (verdict[i] != Verdict::fixed) continue;
    const S weight = S(1e4) / prior.sigma[i];  // far above what the data say, well inside float
    for (int c = 0; c <= n; ++c) row[c] = S(0);
    row[i] = weight;
    row[n] = -weight * offset[i];
    fold_rows(*R, row, 1, n + 1, i, n + 1);
  }
  S step[kMaxTheta];
  for (int i = 0; i < n; ++i) step[i] = (*R)(i, n);
  back_substitute(*R, n, step);
  for (int i = 0; i < n; ++i) {
    if (verdict[i] == Verdict::fixed) step[i] = -offset[i];
  }
  add_step(theta, step);
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
    const S relative = out->sigma[i] / prior.sigma[i];
    out->verdict[i] = relative < rules.observed ? Verdict::observed : relative < rules.weak ? Verdict::weak : Verdict::fixed;
    observed += out->verdict[i] == Verdict::observed ? 1 : 0;
  }
  printed_sigmas(R, theta, out->noise_scale, out->sigma, out->printed_sigma, work);
  return observed;
}

/// Verdicts, sigmas and status from the finished fit.
template <class S>
void judge(Calibrator<S>* calibrator, const ThetaPrior<S>& prior, const ReleaseRules<S>& rules, Release<S>* out) {
  PackedTriangle<S> R = calibrator->theta_triangle();
  const CalibrationFit<S>& fit = calibrator->fit();
  const int n = calibrator->theta().columns();
  const S ratio = fit.dof > S(0) ? fit.chi2 / fit.dof : S(0);
  out->noise_scale = ratio > S(1) ? square_root(ratio) : S(1);
  const int observed = judge_parameters(R, calibrator->theta(), prior, rules, out);
  const bool plausible = ratio > rules.least_chi2_per_dof && ratio < rules.most_chi2_per_dof;
  const bool fell = fit.cost <= fit.start_cost * S(1.0001) && is_finite(fit.cost);  // a fit that begins at its minimum may round up
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
    hold_fixed(prior, out->verdict, &R, &out->theta);
  }
}

/// The same of the filter's own calibration: `R` over theta's columns with a right-hand side of zero; it is changed. The
/// filter has paid for its residuals in its weights, so that nothing is left to scale.
template <class S>
void judge_filter(const Calibration<S>& theta, const ThetaPrior<S>& prior, const ReleaseRules<S>& rules, PackedTriangle<S>* R,
                  Release<S>* out) {
  out->theta = theta;
  out->noise_scale = S(1);
  const int observed = judge_parameters(*R, theta, prior, rules, out);
  out->status = 2 * observed >= theta.columns() ? Status::calibrated : Status::insufficient;
  hold_fixed(prior, out->verdict, R, &out->theta);
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
