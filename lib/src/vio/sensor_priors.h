// What the filter believes of the sensors before it sees anything,
// from an earlier session, and when a calibration comes from outside.
#pragma once

#include "vio/window_update.h"

namespace SEGCAL_NS {

/// Column i of a camera behind the extrinsics: fx fy cx cy, then the coefficients.
template <class S>
S lens_entry(const CameraCalibration<S>& camera, int i) {
  return i < kExtrinsicColumns + 4 ? camera.intrinsics(i - kExtrinsicColumns)
                                   : camera.distortion(i - kExtrinsicColumns - 4);
}

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

/// What is known of the sensors is known about the place that is `offset` from theta (over all columns; those of the
/// sensors are read). They stand last, so that their own rows hold exactly their marginal information.
template <class S>
void centre_sensors(Window<S>* w, const S* offset) {
  PackedTriangle<S> R = w->R();
  const int n = w->columns();
  for (int j = camera_column(0); j < n; ++j) {
    S sum = S(0);
    for (int c = j; c < n; ++c) sum += R(j, c) * offset[c];
    R.row(j)[n] = sum;
  }
}

/// The kept information on the sensors as a prior at `given`,
/// seen from the present theta (the start moves the cameras).
template <class S>
void fold_learnt(Window<S>* w) {
  S* offset = w->block;
  for (int j = 0; j < w->columns(); ++j) offset[j] = S(0);
  for (int c = 0; c < w->theta.n_cameras; ++c) {
    const CameraCalibration<S>&now = w->theta.camera[c], &given = w->given.camera[c];
    const Vec3<S> r = so3_log<S>(given.R_CI * now.R_CI.transpose()), dp = given.p_CI - now.p_CI;
    for (int i = 0; i < 3; ++i) {
      offset[camera_column(c) + i] = r(i);
      offset[camera_column(c) + 3 + i] = dp(i);
    }
    for (int i = kExtrinsicColumns; i < now.columns(); ++i)
      offset[camera_column(c) + i] = lens_entry(given, i) - lens_entry(now, i);
  }
  centre_sensors(w, offset);
}

/// Takes a calibration from outside while the filter runs. What it has estimated beside (motion, and biases above all,
/// which took up what the old calibration left) goes where the window's information puts it for the new one: the mean
/// of R's other rows given a step of the sensors. Without that the links of the next seconds would be broken by tens of
/// sigmas. How well the filter knows its sensors stays as it is: forgotten, a few frames would tell them anew, and
/// whatever the path owes to them, places and heading since the start, would move along.
template <class S>
[[gnu::cold]] void take_calibration(const Calibration<S>& theta, Window<S>* w) {
  S delta[kMaxTheta];  // effects behind the sensors included: the filter takes them as they are
  difference(w->theta, theta, delta);
  const S* from = delta;
  S* offset = w->block;
  for (int j = 0; j < w->columns(); ++j) offset[j] = S(0);
  const auto put = [&](int first, int n) {
    for (int j = first; j < first + n; ++j) offset[j] = *from++;
  };
  for (int c = 0; c < theta.n_cameras; ++c) put(camera_column(c), theta.camera[c].columns());
  put(w->imu_column(), kImuColumns);
  centre_sensors(w, offset);
  apply_update(w);
  w->replace_calibration(theta);
}

}  // namespace SEGCAL_NS
