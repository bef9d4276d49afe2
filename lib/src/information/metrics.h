// From R_theta to what it is worth: singular values against the prior, A-, D- and E-optimality, rank, and the
// directions that the motion did not excite (paper, Sec. V-B).
//
// W = R_theta diag(sigma_prior) = U diag(s) V'. In prior units the posterior covariance is V diag(1 / (1 + s^2)) V':
// a blind direction (s = 0) keeps the prior's variance, never an infinite one.
#pragma once

#include "information/release_rules.h"
#include "information/segment_information.h"
#include "math/near.h"
#include "math/resumable.h"
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
    for (int k = j + 1; k < n; ++k)
      if (s[k] > s[best]) best = k;
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
class SingularValues {
 public:
  /// In slices of a few columns; true when s and V are done.
  bool step(S* W, S* V, int n, S* s) {
    SEGCAL_SLICES(place_) {
      for (int i = 0; i < n * n; ++i) V[i] = S(0);
      for (int i = 0; i < n; ++i) V[i * n + i] = S(1);
      rotated_ = true;
      for (sweep_ = 0; sweep_ < 30 && rotated_; ++sweep_) {
        rotated_ = false;
        for (p_ = 0; p_ < n; ++p_) {
          for (int q = p_ + 1; q < n; ++q) rotated_ |= orthogonalise(W, V, n, p_, q);
          if (p_ % 8 == 7) SEGCAL_PAUSE(place_);
        }
        SEGCAL_PAUSE(place_);
      }
      lengths(W, n, s);
      sort_directions(V, n, s);
    }
    SEGCAL_SLICES_END(place_);
  }
  void restart() { place_ = 0; }

 private:
  static void lengths(const S* W, int n, S* s) {
    for (int j = 0; j < n; ++j) {
      S sum = S(0);
      for (int i = 0; i < n; ++i) sum += W[i * n + j] * W[i * n + j];
      s[j] = square_root(sum);
    }
  }
  Place place_ = 0;
  std::int32_t sweep_ = 0, p_ = 0;
  bool rotated_ = false;
};

/// An analysis. Its work W is lent by the owner, kMaxTheta^2
/// numbers: it is needed until directions and metrics are there.
template <class S>
struct InformationAnalysis {
  std::int32_t n = 0;
  S s[kMaxTheta];              ///< singular values against the prior, largest first
  S V[kMaxTheta * kMaxTheta];  ///< column i: direction i, in prior units
  Near<S> W;
  SingularValues<S> values;  ///< under way

  /// Direction i's sigma after the measurement, in units of the prior's.
  S relative_sigma(int i) const { return S(1) / square_root(S(1) + s[i] * s[i]); }
};

/// Begins an analysis; analyse_step() finishes it. Until then it has no directions.
template <class S>
void begin_analysis(const SegmentInformation<S>& information, const S* prior_sigma, InformationAnalysis<S>* out) {
  const int n = information.n_theta;
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) out->W[i * n + j] = j < i ? S(0) : information.R(i, j) * prior_sigma[j];
  }
  out->n = 0;
  out->values.restart();
}

template <class S>
bool analyse_step(int n, InformationAnalysis<S>* out) {
  if (!out->values.step(out->W, out->V, n, out->s)) return false;
  out->n = n;
  return true;
}

template <class S>
void analyse(const SegmentInformation<S>& information, const S* prior_sigma, InformationAnalysis<S>* out) {
  begin_analysis(information, prior_sigma, out);
  while (!analyse_step(information.n_theta, out)) {
  }
}

/// The same from a triangle over [theta | rhs] that already holds
/// the prior's rows: its singular values are sqrt(1 + s^2).
template <class S>
void begin_analysis_with_prior(const PackedTriangle<S>& R, const S* prior_sigma, InformationAnalysis<S>* out) {
  const int n = R.columns() - 1;
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) out->W[i * n + j] = j < i ? S(0) : R(i, j) * prior_sigma[j];
  }
  out->n = 0;
  out->values.restart();
}

template <class S>
bool analyse_with_prior_step(int n, InformationAnalysis<S>* out) {
  if (!analyse_step(n, out)) return false;
  for (int i = 0; i < n; ++i) out->s[i] = out->s[i] > S(1) ? square_root(out->s[i] * out->s[i] - S(1)) : S(0);
  return true;
}

template <class S>
void analyse_with_prior(const PackedTriangle<S>& R, const S* prior_sigma, InformationAnalysis<S>* out) {
  begin_analysis_with_prior(R, prior_sigma, out);
  while (!analyse_with_prior_step(R.columns() - 1, out)) {
  }
}

/// Largest eigenvalue of W'W by power iteration from all of the diagonal's directions at once.
template <class S>
class LargestEigenvalue {
 public:
  /// In slices of 20 iterations; true when value() is it.
  bool step(const S* W, int n) {
    SEGCAL_SLICES(place_) {
      for (int i = 0; i < n; ++i) x_[i] = S(1) + S(i) / S(n);
      value_ = S(0);
      for (iteration_ = 0; iteration_ < 200; ++iteration_) {
        if (iterate(W, n) && iteration_ > 3) break;
        if (iteration_ % 20 == 19) SEGCAL_PAUSE(place_);
      }
    }
    SEGCAL_SLICES_END(place_);
  }
  S value() const { return value_; }
  void restart() { place_ = 0; }

 private:
  /// x <- W'W x / |x|; true if the value has settled.
  bool iterate(const S* W, int n) {
    S y[kMaxTheta], length = S(0);
    for (int i = 0; i < n; ++i) length += x_[i] * x_[i];
    length = square_root(length);
    for (int i = 0; i < n; ++i) x_[i] = x_[i] / length;
    for (int i = 0; i < n; ++i) {
      y[i] = S(0);
      for (int j = 0; j < n; ++j) y[i] += W[i * n + j] * x_[j];
    }
    S next = S(0);
    for (int i = 0; i < n; ++i) next += y[i] * y[i];
    for (int j = 0; j < n; ++j) {
      x_[j] = S(0);
      for (int i = 0; i < n; ++i) x_[j] += W[i * n + j] * y[i];
    }
    const bool settled = absolute(next - value_) <= S(1e-6) * next;
    value_ = next;
    return settled;
  }
  Place place_ = 0;
  std::int32_t iteration_ = 0;
  S value_ = S(0), x_[kMaxTheta];
};

/// Metrics of the covariance normalised by sigma_ref (paper, Eq. (marginal_normalization)); E follows from
/// LargestEigenvalue over a->W.
template <class S>
Metrics<S> metrics_but_E(InformationAnalysis<S>* a, const S* prior_sigma, const S* sigma_ref) {
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
    if (a->relative_sigma(i) < ReleaseRules<S>{}.weak) ++m.rank;
  }
  return m;
}

template <class S>
Metrics<S> metrics_of(InformationAnalysis<S>* a, const S* prior_sigma, const S* sigma_ref) {
  Metrics<S> m = metrics_but_E(a, prior_sigma, sigma_ref);
  LargestEigenvalue<S> largest;
  while (!largest.step(a->W, a->n)) {
  }
  m.E = largest.value();
  return m;
}

}  // namespace SEGCAL_NS
