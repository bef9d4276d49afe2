// Where the device was when an image point was exposed: t = t_stamp + t_d + line_delay (v
// - h/2), or (u - w/2) where the shutter runs along columns, on the IMU's clock (effects time_offset and
// rolling_shutter; docs/diagnosis.md, section 4). All code that predicts a segment's image points does it here.
//
// The keyframe's pose moves on along its own motion for tau = t - t_keyframe: R Exp(w tau), p + v tau + a tau^2 / 2,
// with rate and force of the stored samples in the middle of that time. At tau = 30 ms and a hand's motion of 3 rad/s
// and 5 m/s^2 at 2 Hz, the terms left out are tau^3 / 24 d2w/dt2 = 5e-4 rad and a tenth of a millimetre.
//
// v, w and a are taken as known, so that an image row touches pose, camera and camera terms only. What that leaves out
// is tau J_p by v and tau J_theta by b_g. At 30 ms a velocity known to 1e-3 m/s moves a point by 0.03 mm, where vision
// knows the position to 1 mm: the estimate of v moves by a thirtieth of its sigma, that of all else by less.
#pragma once

#include "segments/segment.h"
#include "sensors/warm_camera.h"

namespace SEGCAL_NS {

template <class S>
struct Exposure {
  Mat3<S> R_GI;
  Vec3<S> p_GI;
  bool moved = false;
  Mat3<S> turn;       ///< Exp(w tau), where moved: a turn d of the keyframe is turn' d here
  Vec3<S> w_I, v_GI;  ///< rate of change of the pose with tau, where asked for
  S warmth = S(0);    ///< degC above 25
};

/// Rate and force in I at t (us after t0), extended along their slope where the samples end.
template <class S>
void motion_at(const Segment<S>& segment, const ImuCalibration<S>& imu, const State<S>& x, std::int32_t t_us, S tau,
               Vec3<S>* w_I, Vec3<S>* dw_I, Vec3<S>* f_I) {
  const S wanted = S(t_us) + S(0.5e6) * tau;  // middle of the time
  const S first = S(segment.imu.time(0)), last = S(segment.imu.time(segment.imu.size() - 1));
  const S inside = wanted < first ? first : wanted > last ? last : wanted;
  const std::int32_t at_us = static_cast<std::int32_t>(inside);
  const InertialReading<S> r = reading_at<S>(segment.imu, at_us);
  const Mat3<S> T_g_inv = inverse_scale_misalignment(imu.gyro_scale, imu.gyro_misalignment);
  *dw_I = T_g_inv * (S(1e6) * gyro_slope_at<S>(segment.imu, at_us));
  *w_I = T_g_inv * (r.gyro - x.b_g) + *dw_I * ((wanted - inside) * S(1e-6));
  *f_I =
      imu.R_AI.transpose() * (inverse_scale_misalignment(imu.accel_scale, imu.accel_misalignment) * (r.accel - x.b_a));
}

/// tau of an image point, s.
template <class S>
S exposure_delay(const Segment<S>& segment, const Observation& z, const Calibration<S>& theta) {
  const S lines = theta.camera[z.camera].line_of(S(z.u), S(z.v));
  return theta.effects.value_of(kTimeOffsetTerm) - S(segment.stamp_shift_ns) * S(1e-9) +
         theta.effects.value_of(kLineDelayTerm) * lines;
}

/// `with_rates`: w_I and v_GI are wanted, for columns of time terms.
template <class S>
Exposure<S> exposure_of(const Segment<S>& segment, const Observation& z, const Calibration<S>& theta, const Vec3<S>& g,
                        bool with_rates) {
  const State<S>& x = segment.states.x[z.keyframe];
  Exposure<S> out;
  if (kHasWarmCamera) out.warmth = S(segment.warmth[z.keyframe]);
  out.R_GI = x.R_GI;
  out.p_GI = x.p_GI;
  out.moved = theta.effects.any_of_time();
  if (!out.moved && !with_rates) return out;
  const S tau = out.moved ? exposure_delay(segment, z, theta) : S(0);
  Vec3<S> dw_I, f_I;
  motion_at(segment, theta.imu, x, segment.t_us[z.keyframe], tau, &out.w_I, &dw_I, &f_I);
  const Vec3<S> a_G = x.R_GI * (f_I + (tau / S(2)) * cross<S>(out.w_I, f_I)) + g;
  out.v_GI = x.v_GI + tau * a_G;
  if (!out.moved) return out;
  out.turn = so3_exp<S>(Vec3<S>(tau * out.w_I));
  out.R_GI = x.R_GI * out.turn;
  out.p_GI += tau * (x.v_GI + (tau / S(2)) * a_G);
  out.w_I += (tau / S(2)) * dw_I;
  return out;
}

template <class S>
[[gnu::always_inline]] inline ImageTerms<S> image_terms_at(const Observation& z, const Calibration<S>& theta) {
  return {theta.effects.any_of_image() ? &theta.effects : nullptr,
          theta.camera[z.camera].share_of_line(S(z.u), S(z.v))};
}

/// Does f(camera) with the camera of an image point, as it was at that temperature.
template <class S, class F>
[[gnu::always_inline]] inline auto with_camera(const Observation& z, const Calibration<S>& theta, S warmth, F f) {
  const CameraCalibration<S>& camera = theta.camera[z.camera];
  if (has_warm_camera(theta)) return f(WarmCamera<S>(camera, theta.effects, warmth).now());
  return f(camera);
}

/// Predicted minus measured pixel of an image point of landmark l. False where there is no image.
template <class S>
bool point_residual(const Segment<S>& segment, const Observation& z, const Calibration<S>& theta, const Vec3<S>& g,
                    const Landmark<S>& l, Vec2<S>* r) {
  const Exposure<S> at = exposure_of(segment, z, theta, g, false);
  return with_camera(z, theta, at.warmth, [&](const CameraCalibration<S>& camera) {
    return reprojection_residual(camera, at.R_GI, at.p_GI, l, Vec2<S>(S(z.u), S(z.v)), r, image_terms_at(z, theta));
  });
}

/// The same with Jacobians by landmark, pose of the keyframe and camera. In a segment that only turned they are taken
/// where the landmark was seen first (visible_translation.h): `p_first`; null: at the pose itself.
template <class S>
bool point_rows(const Observation& z, const Calibration<S>& theta, const Exposure<S>& at, const Landmark<S>& l,
                const Vec3<S>* p_first, ReprojectionRows<S>* rows) {
  const Vec2<S> uv(S(z.u), S(z.v));
  const ImageTerms<S> terms = image_terms_at(z, theta);
  const bool seen = with_camera(z, theta, at.warmth, [&](const CameraCalibration<S>& camera) {
    return p_first ? reprojection_rows(camera, at.R_GI, at.p_GI, at.R_GI, *p_first, l, uv, rows, terms)
                   : reprojection_rows(camera, at.R_GI, at.p_GI, l, uv, rows, terms);
  });
  if (!seen) return false;
  if (at.moved)
    rows->J_pose.template leftCols<3>() = (rows->J_pose.template leftCols<3>() * at.turn.transpose()).eval();
  if (has_warm_camera(theta))
    WarmCamera<S>(theta.camera[z.camera], theta.effects, at.warmth).bring_back(&rows->J_camera);
  return true;
}

/// Column of a camera term, px per unit; after point_rows().
template <class S>
Vec2<S> camera_term_column(const Term& t, const Observation& z, const Calibration<S>& theta, const Exposure<S>& at,
                           bool turned_only, const ReprojectionRows<S>& rows) {
  const CameraCalibration<S>& camera = theta.camera[z.camera];
  if (kHasWarmCamera && t.of_warm_camera())
    return WarmCamera<S>(camera, theta.effects, at.warmth).column(t.a, rows.J_camera);
  if (!t.of_time()) {
    const Vec2<S> phi = image_phi(t, rows.d, image_terms_at(z, theta).row);
    return with_camera(z, theta, at.warmth, [&phi](const CameraCalibration<S>& now) {
      return Vec2<S>(now.intrinsics(0) * phi.x(), now.intrinsics(1) * phi.y());
    });
  }
  // The pose turns by w in its own frame, which is a turn of `turn` w for the keyframe.
  const Vec3<S> w = at.moved ? Vec3<S>(at.turn * at.w_I) : at.w_I;
  Vec2<S> column = rows.J_pose.template leftCols<3>() * w;
  if (!turned_only) column += rows.J_pose.template rightCols<3>() * at.v_GI;
  return t.a == 0 ? column : Vec2<S>(column * camera.line_of(S(z.u), S(z.v)));
}

}  // namespace SEGCAL_NS
