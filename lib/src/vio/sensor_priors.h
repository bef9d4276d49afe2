// What the filter believes of the sensors before it sees anything,
// from an earlier session, and when a calibration comes from outside.
#pragma once

#include "vio/window_update.h"

namespace SEGCAL_NS {

/// Prior sigma of column i of camera c; 0: the column is not estimated.
template <class S>
S camera_sigma(const VioOptions<S>& options, const CameraCalibration<S>& camera, int i) {
  if (i < 3) return options.sigma_r_CI;
  if (i < kExtrinsicColumns) return options.sigma_p_CI;
  if (options.sigma_focal == S(0) || i >= camera.columns()) return S(0);
  if (i < kExtrinsicColumns + 2) return options.sigma_focal * camera.intrinsics(0);
  return i < kExtrinsicColumns + 4 ? options.sigma_centre : options.sigma_distortion;
}

/// Prior sigma of entry i of the IMU's calibration; 0: it is not estimated.
template <class S>
S imu_sigma(const VioOptions<S>& options, int i) {
  return i < 6 ? options.sigma_gyro : i < 12 ? options.sigma_accel : options.sigma_r_AI;
}

/// The kept information on the sensors as a prior at `given`,
/// seen from the present theta (the start moves the extrinsics).
template <class S>
void fold_learnt(Window<S>* w) {
  PackedTriangle<S> R = w->R();
  const int n = w->columns();
  S* offset = w->block;
  for (int j = 0; j < n; ++j) offset[j] = S(0);
  for (int c = 0; c < w->theta.n_cameras; ++c) {
    const CameraCalibration<S>&now = w->theta.camera[c], &given = w->given.camera[c];
    const Vec3<S> r = so3_log<S>(given.R_CI * now.R_CI.transpose()), dp = given.p_CI - now.p_CI;
    for (int i = 0; i < 3; ++i) {
      offset[camera_column(c) + i] = r(i);
      offset[camera_column(c) + 3 + i] = dp(i);
    }
  }
  for (int j = camera_column(0); j < n; ++j) {
    S sum = S(0);
    for (int c = j; c < n; ++c) sum += R(j, c) * offset[c];
    R.row(j)[n] = sum;
  }
}

/// What was learnt about the sensors is replaced by a prior at their new values; the poses, given the sensors, are
/// believed as before. (The sensors stand last: their own rows hold exactly their marginal information.)
template <class S>
void replace_sensor_priors(Window<S>* w, const VioOptions<S>& options) {
  PackedTriangle<S> R = w->R();
  for (int j = camera_column(0); j < w->columns(); ++j) {
    for (int c = j; c <= w->columns(); ++c) R.row(j)[c] = S(0);
    const int i = j - camera_column(0), camera = i / kMaxCameraColumns;
    const S sigma = options.calibrated_share *
                    (j >= w->imu_column() ? imu_sigma(options, j - w->imu_column())
                                          : camera_sigma(options, w->theta.camera[camera], i % kMaxCameraColumns));
    if (sigma > S(0)) R.row(j)[j] = S(1) / sigma;
  }
}

/// Takes a calibration from outside while the filter runs. What it has estimated beside
/// (motion, and biases above all, which took up what the old calibration left) goes where the
/// window's information puts it for the new one: the mean of R's other rows given a step of
/// the sensors. Without that the links of the next seconds would be broken by tens of sigmas.
template <class S>
[[gnu::cold]] void take_calibration(const Calibration<S>& theta, const VioOptions<S>& options, Window<S>* w) {
  S delta[kMaxTheta];  // effects behind the sensors included: the filter takes them as they are
  difference(w->theta, theta, delta);
  PackedTriangle<S> R = w->R();
  const S* from = delta;
  const auto put = [&](int first, int n) {
    for (int j = first; j < first + n; ++j) {
      S* r = R.row(j);
      for (int c = j; c < w->columns(); ++c) r[c] = c == j ? S(1) : S(0);
      r[w->columns()] = *from++;
    }
  };
  for (int j = camera_column(0); j < w->imu_column(); ++j) {
    for (int c = j; c <= w->columns(); ++c) R.row(j)[c] = S(0);  // a lens with fewer columns leaves some
  }
  for (int c = 0; c < theta.n_cameras; ++c) put(camera_column(c), theta.camera[c].columns());
  put(w->imu_column(), kImuColumns);
  apply_update(w);
  w->replace_calibration(theta);
  replace_sensor_priors(w, options);
}

}  // namespace SEGCAL_NS
