// The calibration vector theta (docs/design.md, section 2): values, their order in columns, and how a step is applied.
//
// Columns: per camera [r_CI 3 | p_CI 3 | fx fy cx cy | distortion 1 or 4], then
// [gyro s 3 | gyro m 3 | accel s 3 | accel m 3 | r_AI 3], then the estimated terms of effects (effect_terms.h).
#pragma once

#include "math/elementary.h"
#include "math/so3.h"
#include "math/types.h"
#include "sensors/effect_terms.h"

namespace SEGCAL_NS {

enum class Distortion : std::int32_t { fov = 0, radtan = 1, equidistant = 2 };

constexpr int kMaxCameras = SEGCAL_MAX_CAMERAS;
constexpr int kExtrinsicColumns = 6;
constexpr int kIntrinsicColumns = 8;  // fx fy cx cy and up to four distortion coefficients
constexpr int kMaxCameraColumns = kExtrinsicColumns + kIntrinsicColumns;
constexpr int kImuColumns = 15;  // gyro s m, accel s m, r_AI
constexpr int kMaxSensorColumns = kMaxCameras * kMaxCameraColumns + kImuColumns;
constexpr int kMaxTheta = kMaxSensorColumns + kMaxEffectEstimates;
constexpr int kMaxWideTheta = kMaxSensorColumns + kMaxEffectColumns;  ///< with candidates

template <class S>
struct CameraCalibration {
  Distortion model = Distortion::radtan;
  Mat3<S> R_CI = Mat3<S>::Identity();            ///< rotates a vector in I into C
  Vec3<S> p_CI = Vec3<S>::Zero();                ///< p_C = R_CI p_I + p_CI; m
  Vec<S, 4> intrinsics{S(1), S(1), S(0), S(0)};  ///< fx fy cx cy; px
  Vec<S, 4> distortion = Vec<S, 4>::Zero();      ///< fov: w. radtan: k1 k2 p1 p2. equidistant: k1..k4
  /// px; known, no part of theta: terms count lines from here, which are rows. Below zero lines are columns, and this
  /// is minus the middle one: a shutter that runs across the image.
  S middle_line = S(240);

  S line_of(S u, S v) const { return middle_line < S(0) ? u + middle_line : v - middle_line; }
  /// -1 to 1 over the image.
  S share_of_line(S u, S v) const { return line_of(u, v) / absolute(middle_line); }

  int distortion_columns() const { return model == Distortion::fov ? 1 : 4; }
  int columns() const { return kExtrinsicColumns + 4 + distortion_columns(); }
};

/// w_m = T_g w_I + b_g, a_m = T_a R_AI f_I + b_a with T = [[sx,
/// mx, my], [0, sy, mz], [0, 0, sz]] (paper, Eq. (calib_t)).
template <class S>
struct ImuCalibration {
  Vec3<S> gyro_scale = Vec3<S>::Ones();
  Vec3<S> gyro_misalignment = Vec3<S>::Zero();
  Vec3<S> accel_scale = Vec3<S>::Ones();
  Vec3<S> accel_misalignment = Vec3<S>::Zero();
  Mat3<S> R_AI = Mat3<S>::Identity();
};

template <class S>
struct Calibration {
  int n_cameras = 1;
  CameraCalibration<S> camera[kMaxCameras];
  ImuCalibration<S> imu;
  EffectTerms<S> effects;

  /// First column of camera c.
  int camera_column(int c) const {
    int column = 0;
    for (int i = 0; i < c; ++i) column += camera[i].columns();
    return column;
  }
  /// Columns of all cameras together; also the first IMU column.
  int imu_column() const { return camera_column(n_cameras); }
  int effect_column() const { return imu_column() + kImuColumns; }
  /// n_theta.
  int columns() const { return effect_column() + effects.count(); }
};

/// T = [[sx, mx, my], [0, sy, mz], [0, 0, sz]].
template <class S>
Mat3<S> scale_misalignment(const Vec3<S>& s, const Vec3<S>& m) {
  Mat3<S> T;
  T << s.x(), m.x(), m.y(), S(0), s.y(), m.z(), S(0), S(0), s.z();
  return T;
}

/// One camera moved by its columns(). Rotation: R <- Exp(d) R; everything else is added.
template <class S>
void add_camera_step(CameraCalibration<S>* camera, const S* delta) {
  camera->R_CI = renormalised<S>(so3_exp<S>(Vec3<S>(delta[0], delta[1], delta[2])) * camera->R_CI);
  camera->p_CI += Vec3<S>(delta[3], delta[4], delta[5]);
  for (int i = 0; i < 4; ++i) camera->intrinsics(i) += delta[6 + i];
  for (int i = 0; i < camera->distortion_columns(); ++i) camera->distortion(i) += delta[10 + i];
}

/// theta <- theta [+] delta. Rotations: R <- Exp(d) R; everything else is added. `delta` has columns() entries.
template <class S>
void add_step(Calibration<S>* theta, const S* delta) {
  const auto three = [](const S* d) { return Vec3<S>(d[0], d[1], d[2]); };
  for (int c = 0; c < theta->n_cameras; ++c) {
    add_camera_step(&theta->camera[c], delta);
    delta += theta->camera[c].columns();
  }
  ImuCalibration<S>& imu = theta->imu;
  imu.gyro_scale += three(delta);
  imu.gyro_misalignment += three(delta + 3);
  imu.accel_scale += three(delta + 6);
  imu.accel_misalignment += three(delta + 9);
  imu.R_AI = renormalised<S>(so3_exp<S>(three(delta + 12)) * imu.R_AI);
  for (int i = 0; i < theta->effects.count(); ++i) theta->effects.value[i] += delta[kImuColumns + i];
}

/// delta = b [-] a, so that add_step(a, delta) = b. Both have the same cameras, models and terms.
template <class S>
void difference(const Calibration<S>& a, const Calibration<S>& b, S* delta) {
  const auto put = [](S* d, const Vec3<S>& v) {
    for (int i = 0; i < 3; ++i) d[i] = v(i);
  };
  for (int c = 0; c < a.n_cameras; ++c) {
    const CameraCalibration<S>&ca = a.camera[c], &cb = b.camera[c];
    put(delta, so3_log<S>(cb.R_CI * ca.R_CI.transpose()));
    put(delta + 3, cb.p_CI - ca.p_CI);
    for (int i = 0; i < 4; ++i) delta[6 + i] = cb.intrinsics(i) - ca.intrinsics(i);
    for (int i = 0; i < ca.distortion_columns(); ++i) delta[10 + i] = cb.distortion(i) - ca.distortion(i);
    delta += ca.columns();
  }
  put(delta, b.imu.gyro_scale - a.imu.gyro_scale);
  put(delta + 3, b.imu.gyro_misalignment - a.imu.gyro_misalignment);
  put(delta + 6, b.imu.accel_scale - a.imu.accel_scale);
  put(delta + 9, b.imu.accel_misalignment - a.imu.accel_misalignment);
  put(delta + 12, so3_log<S>(b.imu.R_AI * a.imu.R_AI.transpose()));
  for (int i = 0; i < a.effects.count(); ++i) delta[kImuColumns + i] = b.effects.value[i] - a.effects.value[i];
}

}  // namespace SEGCAL_NS
