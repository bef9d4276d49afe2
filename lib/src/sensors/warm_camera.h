// The camera at another temperature than 25 degC (effect camera_temperature, docs/diagnosis.md, section 4). With dT the
// warmth, c the effect's values (r 3, f, cx, cy) and theta's camera as it is at 25 degC:
//
//   R_CI(dT) = Exp(dT r) R_CI      f(dT) = (1 + dT c_f) f      c(dT) = c + dT (c_cx fx, c_cy fy)
#pragma once

#include "sensors/calibration.h"

namespace SEGCAL_NS {

constexpr int kWarmCameraTerms = 6;
/// A build that has no columns for all of them has no code for them either.
constexpr bool kHasWarmCamera = kMaxEffectColumns >= kWarmCameraTerms;

/// Whether calibration's terms move its cameras with temperature.
template <class S>
bool has_warm_camera(const Calibration<S>& theta) {
  return kHasWarmCamera && theta.effects.any_of_warm_camera();
}

/// One camera at one temperature, and the way back of its derivatives.
template <class S>
class WarmCamera {
 public:
  [[gnu::cold]] WarmCamera(const CameraCalibration<S>& camera, const EffectTerms<S>& effects, S warmth)
      : camera_(camera), now_(camera), warmth_(warmth) {
    const auto moved_by = [&](int i) {
      return warmth * effects.value_of(Term{TermKind::camera_warmth, static_cast<std::uint8_t>(i), 0, 0});
    };
    rotation_ = Vec3<S>(moved_by(0), moved_by(1), moved_by(2));
    turn_ = so3_exp<S>(rotation_);
    now_.R_CI = turn_ * camera.R_CI;
    zoom_ = S(1) + moved_by(3);
    for (int i = 0; i < 2; ++i) {
      shift_[i] = moved_by(4 + i);
      now_.intrinsics(i) = zoom_ * camera.intrinsics(i);
      now_.intrinsics(2 + i) += shift_[i] * camera.intrinsics(i);
    }
  }

  const CameraCalibration<S>& now() const { return now_; }
  /// What a camera is at 25 degC that is `now`; another one than now(), as an odometry has estimated it.
  [[gnu::cold]] CameraCalibration<S> at_25_degC(CameraCalibration<S> now) const {
    now.R_CI = (turn_.transpose() * now.R_CI).eval();
    for (int i = 0; i < 2; ++i) {
      now.intrinsics(i) /= zoom_;
      now.intrinsics(2 + i) -= shift_[i] * now.intrinsics(i);
    }
    return now;
  }

  /// Rows by the camera as it is now become rows by the camera at 25 degC. [r_CI 3 | p_CI 3 | fx fy cx cy ...]
  template <class Rows>
  void bring_back(Rows* J) const {
    // Exp(dT r) Exp(d) = Exp(Exp(dT r) d) Exp(dT r)
    J->template leftCols<3>() = (J->template leftCols<3>() * turn_).eval();
    for (int i = 0; i < 2; ++i)
      J->col(kFocal + i) = (zoom_ * J->col(kFocal + i) + shift_[i] * J->col(kFocal + 2 + i)).eval();
  }

  /// The derivative by value i, from rows that were brought back.
  template <class Rows>
  Vec2<S> column(int i, const Rows& J) const {
    const Vec<S, 4>& f = camera_.intrinsics;
    if (i >= 4) return warmth_ * f(i - 4) * J.col(kFocal + i - 2);
    // d Exp(dT r) = Exp(dT r) (J_right d(dT r))^
    if (i < 3) return warmth_ * (J.template leftCols<3>() * so3_right_jacobian<S>(rotation_).col(i));
    Vec2<S> zoomed = Vec2<S>::Zero();
    for (int k = 0; k < 2; ++k) zoomed += f(k) * (J.col(kFocal + k) - shift_[k] * J.col(kFocal + 2 + k));
    return warmth_ / zoom_ * zoomed;
  }

 private:
  static constexpr int kFocal = kExtrinsicColumns;
  const CameraCalibration<S>& camera_;
  CameraCalibration<S> now_;
  S warmth_, zoom_, shift_[2];
  Vec3<S> rotation_;
  Mat3<S> turn_;
};

/// The cameras become what they are at this temperature: for a filter, which has no model of it.
template <class S>
void move_cameras(S warmth, Calibration<S>* theta) {
  if (!has_warm_camera(*theta)) return;
  for (int c = 0; c < theta->n_cameras; ++c)
    theta->camera[c] = CameraCalibration<S>(WarmCamera<S>(theta->camera[c], theta->effects, warmth).now());
}

}  // namespace SEGCAL_NS
