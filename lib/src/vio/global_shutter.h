// Image points as a shutter that exposes all lines at once would have had them: the filter knows no other.
//
// A point was exposed tau = line_delay lines after its frame's stamp (effect rolling_shutter). With the rate w of the
// gyroscope in the middle of that time, extended from the stamp along its slope, its direction at the stamp is R_CI
// Exp(tau w) R_CI' h. What moving adds, v tau / depth, is left: at 0.5 m/s, 2 m and 10 ms 2.5 mrad, where 5 rad/s turn
// the image by 50. A phone that is shaken with 50 us/row, 24 ms from top to bottom, moves points at the border by 60
// px. Segments hold the points as they came and take the whole motion into account (segments/exposure.h).
#pragma once

#include "sensors/camera.h"
#include "sensors/imu_history.h"
#include "sensors/track_point.h"

namespace SEGCAL_NS {

constexpr bool kHasLineDelay = kMaxEffectEstimates > 0;

/// Rates in I about a stamp within `imu`, along their slope there: of what comes after it there may be no samples yet.
template <class S>
struct RateAbout {
  Vec3<S> w_I, slope;

  RateAbout(const ImuHistory<S>& imu, std::int64_t t_ns, const ImuCalibration<S>& calibration, const Vec3<S>& b_g) {
    const Mat3<S> T_g_inv = inverse_scale_misalignment(calibration.gyro_scale, calibration.gyro_misalignment);
    w_I = T_g_inv * (reading_at<S>(imu, t_ns).gyro - b_g);
    slope = T_g_inv * (S(1e9) * gyro_slope_at<S>(imu, t_ns));
  }
  Mat3<S> turn(S tau) const { return so3_exp<S>(Vec3<S>(tau * (w_I + (tau / S(2)) * slope))); }
};

/// Turns a point; it stays where it is if the lens has no direction for it.
template <class S>
[[gnu::cold, gnu::noinline]] void turn_to_stamp(const CameraCalibration<S>& camera, S line_delay,
                                                const RateAbout<S>& rate, Vec2<S>* uv) {
  Vec3<S> h;
  Vec2<S> turned;
  if (!unproject(camera, *uv, &h)) return;
  const Mat3<S> turn = rate.turn(line_delay * camera.line_of(uv->x(), uv->y()));
  if (project(camera, Vec3<S>(camera.R_CI * (turn * (camera.R_CI.transpose() * h))), &turned)) *uv = turned;
}

}  // namespace SEGCAL_NS
