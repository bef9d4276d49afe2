// What segments said about theta that are kept no longer: epochs.
//
// A segment whose states and landmarks are eliminated says |R delta - d|^2 + rho^2 about delta = theta [-] theta_0,
// near the theta_0 where it was linearised. Such rows of many segments fold into one triangle of n (n + 3) / 2 numbers,
// whatever their number: that is an epoch. It cannot be linearised again. A calibration takes epochs beside the
// segments that can, as it takes its prior; where theta has left theta_0, with its sigmas widened.
//
// By how much its segments disagree about theta is measured as each comes, as scatter.h does of the segments that are
// kept: from its pull on what was known with it. The sum tells by how much sigmas are to be scaled, and what a
// comparison with others must exceed.
#pragma once

#include "calibration/moved_rows.h"
#include "calibration/prior.h"
#include "information/marginal.h"
#include "information/segment_information.h"

namespace SEGCAL_NS {

/// How far theta may be from theta_0 in each entry: delta^2 over (prior's sigma x the epoch's own sigma). The quadratic
/// lacks terms in delta^2, and calibrations are curved over the range that priors allow: in the epoch's own sigmas its
/// optimum is off by some delta^2 / (sigma_prior sigma). Of 224 synthetic cases nine in ten within the bound have their
/// worst entry within half a sigma of the fit's optimum; beyond it, with sigmas widened in proportion, within 0.8 of
/// those, up to a hundred times the bound (docs/results.md, "Epochs").
constexpr double kMostBent = 1.5;
/// Exceeding the bound by less is not worth another fit.
constexpr double kWorthWidening = 1.1;
/// Of the prior's sigma: an entry that the epoch tells no better is not asked. There is nothing left to be widened, and
/// where the prior holds theta, what there is of a distance is rounding.
constexpr double kHardlyTold = 0.8;

/// What is left of a segment's pull on theta, and what noise as stated leaves of it (scatter.h).
template <class S>
struct Pull {
  S found = S(0), expected = S(0);
};

template <class S>
struct Epoch {
  std::int32_t segments = 0, image_points = 0;
  std::uint32_t first_session = 0, last_session = 0;
  std::uint32_t last_serial = 0;      ///< of its newest segment
  Pull<S> pulls;                      ///< of its segments, each on what was known when it came
  S dof = S(0);                       ///< residuals minus states and landmarks, theta not counted
  Calibration<S> theta;               ///< theta_0
  SegmentInformation<S> information;  ///< over [theta | rhs]; its own dof is not used

  int columns() const { return theta.columns(); }

  void begin(const Calibration<S>& at, std::uint32_t session) {
    segments = image_points = 0;
    first_session = last_session = session;
    last_serial = 0;
    dof = S(0);
    pulls = {};
    theta = at;
    information.n_theta = at.columns();
    information.triangle().clear();
  }

  /// Takes the rows of one segment at theta_0: the triangle over [theta | rhs], `residual_dof` for dof.
  [[gnu::cold]] void add(const PackedTriangle<S>& rows, S residual_dof, const Pull<S>& pull, std::uint32_t session,
                         std::uint32_t serial) {
    const int n = columns();
    // Beside what is there already: in a large sum float would lose what one segment adds.
    PackedTriangle<S> T = information.triangle();
    const S before = T(n, n);
    T.row(n)[n] = S(0);
    fold_rows_of(rows, 0, n);
    pulls.found += pull.found;
    pulls.expected += pull.expected;
    fold_rows_of(rows, n, n + 1);
    T.row(n)[n] = square_root(before * before + T(n, n) * T(n, n));
    dof += residual_dof;
    last_session = session;
    last_serial = serial;
    ++segments;
  }

  /// Takes in another epoch, whose rows are moved to this one's theta_0.
  [[gnu::cold]] void merge(const Epoch& other) {
    const int n = columns();
    S offset[kMaxTheta];
    difference(other.theta, theta, offset);
    PackedTriangle<S> T = information.triangle();
    fold_moved_rows(other.information, offset, n + 1, &T);
    segments += other.segments;
    image_points += other.image_points;
    dof += other.dof;
    pulls.found += other.pulls.found;
    pulls.expected += other.pulls.expected;
    first_session = other.first_session < first_session ? other.first_session : first_session;
    last_session = other.last_session > last_session ? other.last_session : last_session;
    last_serial = other.last_serial > last_serial ? other.last_serial : last_serial;
  }

  /// Its rows as a segment's information at `at`.
  [[gnu::cold]] void move_to(const Calibration<S>& at, SegmentInformation<S>* out) const {
    const int n = columns();
    S offset[kMaxTheta], row[kMaxTheta + 1];
    difference(theta, at, offset);
    out->n_theta = n;
    out->dof = static_cast<std::int32_t>(dof < S(1e9) ? dof : S(1e9));
    PackedTriangle<S> T = out->triangle();
    T.clear();
    for (int i = 0; i <= n; ++i) {
      moved_row(information, offset, i, row);
      for (int c = i; c <= n; ++c) T.row(i)[c] = row[c];
    }
  }

  static constexpr int kScratch = packed_size(kMaxTheta + 1);
  /// How far beyond the bound (kMostBent) theta is, 1 at the bound. `scratch`: kScratch numbers. Where segments scatter
  /// by s times their sigmas, so do those of the epoch.
  [[gnu::cold]] S bent_at(const Calibration<S>& at, const ThetaPrior<S>& prior, S* scratch) const {
    const int n = columns();
    S offset[kMaxTheta], row[kMaxTheta + 1];
    difference(theta, at, offset);
    PackedTriangle<S> T(scratch, n + 1);
    write_prior(prior, theta, &T);
    fold_moved(information, theta, theta, &T);
    const S variance = pulls.expected > S(0) ? pulls.found / pulls.expected : S(1);
    const S most = S(kMostBent) * (variance > S(1) ? square_root(variance) : S(1));
    S bent = S(0);
    for (int i = 0; i < n; ++i) {
      const S one = S(1), sigma = marginal_sigma(T, n, i, &one, 1, row);
      if (sigma > S(kHardlyTold) * prior.sigma[i]) continue;
      const S of_entry = offset[i] * offset[i] / (most * prior.sigma[i] * sigma);
      if (of_entry > bent) bent = of_entry;
    }
    return bent;
  }
  /// Where theta is beyond the bound, its sigmas become wider by what it is exceeded by, so that it tells as much as it
  /// is right. True if that changed anything. `scratch`: kScratch numbers.
  [[gnu::cold]] bool widen_for(const Calibration<S>& at, const ThetaPrior<S>& prior, S* scratch) {
    const S bent = bent_at(at, prior, scratch);
    if (!(bent > S(kWorthWidening))) return false;
    const int n = columns();
    PackedTriangle<S> T = information.triangle();
    for (int i = 0; i < n; ++i) {
      for (int c = i; c <= n; ++c) T.row(i)[c] /= bent;
    }
    return true;
  }

  /// Its cost at theta, without rho^2, which nothing can lower.
  S cost(const Calibration<S>& at) const {
    const int n = columns();
    S offset[kMaxTheta], row[kMaxTheta + 1], sum = S(0);
    difference(theta, at, offset);
    for (int i = 0; i < n; ++i) {
      moved_row(information, offset, i, row);
      sum += row[n] * row[n];
    }
    return sum;
  }

 private:
  void fold_rows_of(const PackedTriangle<S>& rows, int from, int until) {
    const int n = columns();
    PackedTriangle<S> T = information.triangle();
    S row[kMaxTheta + 1];
    for (int i = from; i < until; ++i) {
      for (int c = 0; c <= n; ++c) row[c] = c < i ? S(0) : rows(i, c);
      fold_rows(T, row, 1, n + 1, i, n + 1);
    }
  }
};

}  // namespace SEGCAL_NS
