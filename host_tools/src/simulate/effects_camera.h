// Catalogue effects on the camera (docs/diagnosis.md, section 4): when a line is exposed, and where the lens puts it.
#pragma once

#include "effect.h"

namespace host::sim {

/// t_imu = t_stamp + t_d.
class TimeOffset : public Effect {
 public:
  explicit TimeOffset(double t_d_s) : t_d_(t_d_s) {}
  EffectTruth truth() const override { return {"time_offset", {{"t_d", t_d_, "s"}}}; }
  double exposure_time(const CameraCalibration&, double t_stamp, double) const override { return t_stamp + t_d_; }

 private:
  double t_d_;
};

/// The stamp is the middle line's: t = t_stamp + line_delay (v - h / 2), or (u - w / 2) where lines are columns.
class RollingShutter : public Effect {
 public:
  explicit RollingShutter(double line_delay_s) : line_delay_(line_delay_s) {}
  EffectTruth truth() const override { return {"rolling_shutter", {{"line_delay", line_delay_, "s/row"}}}; }
  double exposure_time(const CameraCalibration& camera, double t_stamp, double line) const override {
    return t_stamp + line_delay_ * (line - camera.lines() / 2.0);
  }

 private:
  double line_delay_;
};

/// On distorted normalised coordinates: d (1 + k |d|^2).
class RadialResidual : public Effect {
 public:
  explicit RadialResidual(double k) : k_(k) {}
  EffectTruth truth() const override { return {"radial_residual", {{"k", k_, "-"}}}; }
  void on_pixel(const CameraCalibration& camera, double t, Eigen::Vector2d& pixel) const override;
  bool moves_pixels() const override { return true; }

 private:
  double k_;
};

/// Brown's tangential terms on distorted normalised coordinates (x, y), r^2 = x^2 + y^2:
/// x += 2 p1 x y + p2 (r^2 + 2 x^2), y += p1 (r^2 + 2 y^2) + 2 p2 x y.
class TangentialResidual : public Effect {
 public:
  TangentialResidual(double p1, double p2) : p1_(p1), p2_(p2) {}
  EffectTruth truth() const override { return {"tangential_residual", {{"p1", p1_, "-"}, {"p2", p2_, "-"}}}; }
  void on_pixel(const CameraCalibration& camera, double t, Eigen::Vector2d& pixel) const override;
  bool moves_pixels() const override { return true; }

 private:
  double p1_, p2_;
};

/// The camera at another temperature than 25 degC, per degC: turned by `turn`, rad, in its own axes; the focal length
/// longer by a share of it, the principal point moved by so many focal lengths.
class CameraTemperature : public Effect {
 public:
  CameraTemperature(const Eigen::Vector3d& turn, double focal, const Eigen::Vector2d& centre)
      : turn_(turn), focal_(focal), centre_(centre) {}
  EffectTruth truth() const override;
  void on_camera_calibration(const CameraMoment& moment, CameraCalibration& calibration) const override;
  bool needs_temperature() const override { return true; }
  bool needs_simulated_imu() const override { return true; }  // which brings the temperature

 private:
  Eigen::Vector3d turn_;    ///< rad/degC
  double focal_;            ///< 1/degC
  Eigen::Vector2d centre_;  ///< 1/degC
};

/// Pixel to distorted normalised coordinates and back.
Eigen::Vector2d normalised(const CameraCalibration& camera, const Eigen::Vector2d& pixel);
Eigen::Vector2d in_pixels(const CameraCalibration& camera, const Eigen::Vector2d& d);

}  // namespace host::sim
