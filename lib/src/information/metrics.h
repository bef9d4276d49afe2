// From R_theta to what it is worth: singular values against the prior, A-, D- and E-optimality, rank, and the
// directions that the motion did not excite (paper, Sec. V-B).
//
// W = R_theta diag(sigma_prior) = U diag(s) V'. In prior units the posterior covariance is V diag(1 / (1 + s^2)) V':
// a blind direction (s = 0) keeps the prior's variance, never an infinite one.
#pragma once

#include "information/segment_information.h"
#include "segments/segment.h"

namespace SEGCAL_NS {

/// Rotates columns p and q of M by an angle of the given cosine and sine.
template <class S>
void rotate_columns(S* M, int n, int p, int q, S cosine, S sine) {
  for (int i = 0; i < n; ++i) {
    const S x = M[i * n + p], y = M[i * n + q];
    M[i * n + p] = cosine * x - sine * y;
    M[i * n + q] = sine * x + cosine * y;
  }
}

/// Makes columns p and q of W orthogonal; false if they are already.
template <class S>
bool orthogonalise(S* W, S* V, int n, int p, int q) {
  const S negligible = std::is_same_v<S, float> ? S(1e-6) : S(1e-14);
  S a = S(0), b = S(0), c = S(0);
  for (int i = 0; i < n; ++i) {
    a += W[i * n + p] * W[i * n + p];
    b += W[i * n + q] * W[i * n + q];
    c += W[i * n + p] * W[i * n + q];
  }
  if (absolute(c) <= negligible * square_root(a) * square_root(b) || c * c < smallest_square<S>) return false;
  const S zeta = (b - a) / (S(2) * c);
  const S t = (zeta < S(0) ? S(-1) : S(1)) / (absolute(zeta) + square_root(S(1) + zeta * zeta));
  const S cosine = S(1) / square_root(S(1) + t * t);
  rotate_columns(W, n, p, q, cosine, cosine * t);
  rotate_columns(V, n, p, q, cosine, cosine * t);
  return true;
}

/// Largest first (selection sort); columns of V along.
template <class S>
void sort_directions(S* V, int n, S* s) {
  for (int j = 0; j < n; ++j) {
    int best = j;
    for (int k = j + 1; k < n; ++k) if (s[k] > s[best]) best = k;
    if (best == j) continue;
    const S swap = s[j];
    s[j] = s[best];
    s[best] = swap;
    for (int i = 0; i < n; ++i) {
      const S x = V[i * n + j];
      V[i * n + j] = V[i * n + best];
      V[i * n + best] = x;
    }
  }
}

/// One-sided Jacobi (Hestenes): rotates the columns of W (n x n, row-major) until they are orthogonal and collects the
/// rotations in V; the columns' lengths are then the singular values, sorted from the largest.
template <class S>
void singular_values(S* W, S* V, int n, S* s) {
  for (int i = 0; i < n * n; ++i) V[i] = S(0);
  for (int i = 0; i < n; ++i) V[i * n + i] = S(1);
  bool rotated = true;
  for (int sweep = 0; sweep < 30 && rotated; ++sweep) {
    rotated = false;
    for (int p = 0; p < n; ++p) {
      for (int q = p + 1; q < n; ++q) rotated |= orthogonalise(W, V, n, p, q);
    }
  }
  for (int j = 0; j < n; ++j) {
    S sum = S(0);
    for (int i = 0; i < n; ++i) sum += W[i * n + j] * W[i * n + j];
    s[j] = square_root(sum);
  }
  sort_directions(V, n, s);
}

/// Memory of one analysis.
template <class S>
struct InformationAnalysis {
  std::int32_t n = 0;
  S s[kMaxTheta];                   ///< singular values against the prior, largest first
  S V[kMaxTheta * kMaxTheta];       ///< column i: direction i, in prior units
  S W[kMaxTheta * kMaxTheta];

  /// Direction i's sigma after the measurement, in units of the prior's.
  S relative_sigma(int i) const { return S(1) / square_root(S(1) + s[i] * s[i]); }
};

/// A direction counts as excited if its sigma falls below half the prior's.
template <class S>
constexpr S kExcited = S(0.5);

template <class S>
void analyse(const SegmentInformation<S>& information, const S* prior_sigma, InformationAnalysis<S>* out) {
  const int n = out->n = information.n_theta;
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) out->W[i * n + j] = j < i ? S(0) : information.R(i, j) * prior_sigma[j];
  }
  singular_values(out->W, out->V, n, out->s);
}

/// Largest eigenvalue of W'W by power iteration from all of the diagonal's directions at once.
template <class S>
S largest_eigenvalue(const S* W, int n) {
  S x[kMaxTheta], y[kMaxTheta], value = S(0);
  for (int i = 0; i < n; ++i) x[i] = S(1) + S(i) / S(n);
  for (int iteration = 0; iteration < 200; ++iteration) {
    S length = S(0);
    for (int i = 0; i < n; ++i) length += x[i] * x[i];
    length = square_root(length);
    for (int i = 0; i < n; ++i) x[i] = x[i] / length;
    for (int i = 0; i < n; ++i) {
      y[i] = S(0);
      for (int j = 0; j < n; ++j) y[i] += W[i * n + j] * x[j];
    }
    S next = S(0);
    for (int i = 0; i < n; ++i) next += y[i] * y[i];
    for (int j = 0; j < n; ++j) {
      x[j] = S(0);
      for (int i = 0; i < n; ++i) x[j] += W[i * n + j] * y[i];
    }
    const bool settled = absolute(next - value) <= S(1e-6) * next;
    value = next;
    if (settled && iteration > 3) break;
  }
  return value;
}

/// The same from a triangle over [theta | rhs] that already holds the prior's rows: its singular values are sqrt(1 + s^2).
template <class S>
void analyse_with_prior(const PackedTriangle<S>& R, const S* prior_sigma, InformationAnalysis<S>* out) {
  const int n = out->n = R.columns() - 1;
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) out->W[i * n + j] = j < i ? S(0) : R(i, j) * prior_sigma[j];
  }
  singular_values(out->W, out->V, n, out->s);
  for (int i = 0; i < n; ++i) out->s[i] = out->s[i] > S(1) ? square_root(out->s[i] * out->s[i] - S(1)) : S(0);
}

/// Metrics of the covariance normalised by sigma_ref (paper, Eq. (marginal_normalization)).
template <class S>
Metrics<S> metrics_of(InformationAnalysis<S>* a, const S* prior_sigma, const S* sigma_ref) {
  Metrics<S> m;
  const int n = a->n;
  // M = diag(prior / ref) V diag(1 / sqrt(1 + s^2)): the normalised covariance is M M'.
  S A = S(0);
  for (int j = 0; j < n; ++j) {
    const S ratio = prior_sigma[j] / sigma_ref[j];
    for (int i = 0; i < n; ++i) {
      const S entry = ratio * a->V[j * n + i] * a->relative_sigma(i);
      a->W[i * n + j] = entry;  // transposed: the same singular values
      A += entry * entry;
    }
    m.D += S(2) * logarithm(ratio);
  }
  m.A = A;
  for (int i = 0; i < n; ++i) {
    const S information = S(1) + a->s[i] * a->s[i];
    m.D -= logarithm(information);
    m.gain += S(0.5) * logarithm(information);
    if (a->relative_sigma(i) < kExcited<S>) ++m.rank;
  }
  m.E = largest_eigenvalue(a->W, n);
  return m;
}

}  // namespace SEGCAL_NS
