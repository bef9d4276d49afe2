// How well the window knows its state and the sensors: parts of
// the covariance R^-1 R^-T, and the sensors' own information.
#pragma once

#include "math/small_solvers.h"
#include "vio/vio_window.h"

namespace SEGCAL_NS {

/// Covariance of the newest state. Uses the scratch block.
template <class S>
void state_covariance(Window<S>* w, Mat<S, kStateColumns, kStateColumns>* P) {
  for (int i = 0; i < kStateColumns; ++i) {
    covariance_factor(w->R(), w->columns(), state_column(i, w->n_poses - 1), w->block + i * kBlockStride);
    for (int j = 0; j <= i; ++j) {
      (*P)(i, j) = factor_product(w->block + i * kBlockStride, w->block + j * kBlockStride, w->columns());
      (*P)(j, i) = (*P)(i, j);
    }
  }
}

/// The sensors' marginal information as a triangle over theta's columns and a right-hand side of zero: the filter's
/// estimates are its solution. Lenses with one coefficient leave places of the filter empty. About terms of effects the
/// filter learns nothing: their rows stay zero.
template <class S>
void sensor_triangle(Window<S>* w, PackedTriangle<S>* out) {
  std::int32_t from[kMaxTheta];
  int n = 0;
  for (int c = 0; c < w->theta.n_cameras; ++c) {
    for (int i = 0; i < w->theta.camera[c].columns(); ++i) from[n++] = camera_column(c) + i;
  }
  for (int i = 0; i < kImuColumns; ++i) from[n++] = w->imu_column() + i;
  out->clear();
  for (int j = 0; j < n; ++j) {
    for (int c = j; c < n; ++c) out->row(j)[c] = w->R()(from[j], from[c]);
  }
}

template <class S>
void extrinsics_sigma(Window<S>* w, int camera, Vec<S, kExtrinsicColumns>* sigma) {
  for (int i = 0; i < kExtrinsicColumns; ++i) {
    covariance_factor(w->R(), w->columns(), camera_column(camera) + i, w->block);
    (*sigma)(i) = square_root(factor_product<S>(w->block, w->block, w->columns()));
  }
}

}  // namespace SEGCAL_NS
