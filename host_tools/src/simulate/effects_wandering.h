// More effects of real devices that the catalogue has no entry for: what moves to and fro with time or along the image.
// They were chosen when the rules of diagnosis stood, and no rule was made from them.
#pragma once

#include "effects_imu.h"

namespace host::sim {

/// Autofocus that hunts: the focal length is 1 + k sin(2 pi t / 7 s) times the calibrated one.
class FocusHunting : public Effect {
 public:
  explicit FocusHunting(double k) : k_(k) {}
  EffectTruth truth() const override { return {"outside:focus_hunting", {{"k", k_, "-"}}}; }
  void on_camera_calibration(const CameraMoment& moment, CameraCalibration& calibration) const override;

 private:
  double k_;
};

/// A camera that is loose in its mount: it falls to one side or the other, +- angle about its y axis, by a draw
/// every 1.7 s.
class LooseMount : public Effect {
 public:
  explicit LooseMount(double angle_rad) : angle_(angle_rad) {}
  EffectTruth truth() const override { return {"outside:loose_mount", {{"angle", angle_, "rad"}}}; }
  void on_camera_calibration(const CameraMoment& moment, CameraCalibration& calibration) const override;

 private:
  double angle_;
};

/// Stamps of the camera that wander about the right ones, as those
/// of a driver under a load that changes: k sin(2 pi t / 11 s).
class WanderingStamps : public Effect {
 public:
  explicit WanderingStamps(double k_s) : k_(k_s) {}
  EffectTruth truth() const override { return {"outside:wandering_stamps", {{"k", k_, "s"}}}; }
  double exposure_time(const CameraCalibration& camera, double t_stamp, double line) const override;

 private:
  double k_;
};

/// A tone on all axes of the gyroscope within the band of motion: k sin(2 pi 1.3 Hz t).
class GyroHum : public ImuEffect {
 public:
  explicit GyroHum(double k) : k_(k) {}
  EffectTruth truth() const override { return {"outside:gyro_hum", {{"k", k_, "rad/s"}}}; }
  void on_imu(const ImuMoment& moment, ImuReading& reading) const override;

 private:
  double k_;
};

/// A sensor that is read from the middle to both edges at once; the stamp
/// is the mean over all rows: t = t_stamp + k (|v - h / 2| - h / 4).
class TwoWayShutter : public Effect {
 public:
  explicit TwoWayShutter(double k) : k_(k) {}
  EffectTruth truth() const override { return {"outside:two_way_shutter", {{"k", k_, "s/row"}}}; }
  double exposure_time(const CameraCalibration& camera, double t_stamp, double line) const override;

 private:
  double k_;
};

}  // namespace host::sim
