// What all segments have in common: the ties and theta, as one triangle over [ties 3 T | theta | rhs].
//
// Ties stand first, so that the triangle's last rows are theta's marginal. Priors are the first rows folded in; what
// ties have once, whatever the number of segments that see them, is put here and not into the segments' systems.
#pragma once

#include "calibration/chain.h"
#include "calibration/prior.h"

namespace SEGCAL_NS {

template <class S>
class GlobalSystem {
 public:
  /// Sets the size: `ties` of them, `n_theta` entries of theta, candidates included.
  void begin(int ties, int n_theta) {
    ties_ = ties;
    n_theta_ = n_theta;
  }
  int columns() const { return first_theta() + n_theta_; }
  PackedTriangle<S> triangle() { return PackedTriangle<S>(data_, columns() + 1); }
  /// Theta's part: a triangle of its own over [theta | rhs].
  PackedTriangle<S> theta_triangle() {
    const int n = n_theta_ + 1;
    return PackedTriangle<S>(data_ + packed_size(columns() + 1) - packed_size(n), n);
  }

  /// Empties the triangle but for the prior on theta, and its damping.
  void clear_to_prior(const ThetaPrior<S>& prior, const Calibration<S>& theta, S damping) {
    triangle().clear();
    PackedTriangle<S> T = theta_triangle();
    write_prior(prior, theta, &T, damping);
  }

  /// Prior on the inverse distance of tie t, and its damping.
  void add_tie(int t, const Landmark<S>& landmark, const MeasurementModel<S>& model, S damping) {
    const int first = kLandmarkColumns * t;
    fold_scalar(first + 2, S(1) / model.depth_sigma(landmark.rho, false), landmark.rho);
    for (int c = 0; damping > S(0) && c < kLandmarkColumns; ++c) {
      fold_scalar(first + c, damping / kTypicalLandmarkStep<S>, S(0));
    }
  }

  /// Steps of the ties for a given step of theta: [ties | theta].
  const S* solve_ties(const S* theta_step) {
    const PackedTriangle<S> G = triangle();
    const int n = columns(), first = first_theta();
    for (int c = first; c < n; ++c) step_[c] = theta_step[c - first];
    for (int i = first - 1; i >= 0; --i) {
      const S* r = G.row(i);
      step_[i] = over_pivot(less_products(r[n], r, step_, i + 1, n), r[i]);
    }
    return step_;
  }

 private:
  int first_theta() const { return kLandmarkColumns * ties_; }
  void fold_scalar(int column, S weight, S value) {
    PackedTriangle<S> G = triangle();
    const int n = columns() + 1;
    S row[kMaxGlobal + 1];
    for (int c = 0; c < n; ++c) row[c] = S(0);
    row[column] = weight;
    row[n - 1] = -weight * value;
    fold_rows(G, row, 1, n, column, n);
  }

  std::int32_t ties_ = 0, n_theta_ = 0;
  S data_[packed_size(kMaxGlobal + 1)];
  S step_[kMaxGlobal];
};

}  // namespace SEGCAL_NS
