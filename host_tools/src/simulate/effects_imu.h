// Catalogue effects on the IMU (docs/diagnosis.md, section 4),
// added to the reading after scale, misalignment and rotation.
#pragma once

#include "effect.h"

namespace host::sim {

class ImuEffect : public Effect {
 public:
  bool needs_simulated_imu() const override { return true; }
};

/// gyro += T_gs f_I. Rows are gyroscope axes.
class GyroGSensitivity : public ImuEffect {
 public:
  explicit GyroGSensitivity(const Eigen::Matrix3d& T_gs) : T_gs_(T_gs) {}
  EffectTruth truth() const override;
  void on_imu(const ImuMoment& moment, ImuReading& reading) const override;

 private:
  Eigen::Matrix3d T_gs_;  ///< rad s/m
};

/// Per axis: gyro += k w |w| with the true rate w.
class GyroNonlinearity : public ImuEffect {
 public:
  explicit GyroNonlinearity(const Eigen::Vector3d& k) : k_(k) {}
  EffectTruth truth() const override;
  void on_imu(const ImuMoment& moment, ImuReading& reading) const override;

 private:
  Eigen::Vector3d k_;  ///< s/rad
};

/// Per axis: accel += k f^2 with f = [R_AI f_I].
class AccelNonlinearity : public ImuEffect {
 public:
  explicit AccelNonlinearity(const Eigen::Vector3d& k) : k_(k) {}
  EffectTruth truth() const override;
  void on_imu(const ImuMoment& moment, ImuReading& reading) const override;

 private:
  Eigen::Vector3d k_;  ///< s^2/m
};

/// gyro += k (temperature - 25 degC).
class GyroTemperature : public ImuEffect {
 public:
  explicit GyroTemperature(const Eigen::Vector3d& k) : k_(k) {}
  EffectTruth truth() const override;
  void on_imu(const ImuMoment& moment, ImuReading& reading) const override;
  bool needs_temperature() const override { return true; }

 private:
  Eigen::Vector3d k_;  ///< rad/s/degC
};

/// accel += k (temperature - 25 degC).
class AccelTemperature : public ImuEffect {
 public:
  explicit AccelTemperature(const Eigen::Vector3d& k) : k_(k) {}
  EffectTruth truth() const override;
  void on_imu(const ImuMoment& moment, ImuReading& reading) const override;
  bool needs_temperature() const override { return true; }

 private:
  Eigen::Vector3d k_;  ///< m/s^2/degC
};

/// The gyroscope is a first-order low-pass of the true rate: tau dw_m/dt + w_m = w, exactly.
class GyroLag : public ImuEffect {
 public:
  explicit GyroLag(double tau_s) : tau_(tau_s) {}
  EffectTruth truth() const override { return {"gyro_lag", {{"tau", tau_, "s"}}}; }
  void on_imu(const ImuMoment& moment, ImuReading& reading) const override;

 private:
  double tau_;
};

/// The y and z accelerometers sit at r_y, r_z from the x one: axis i reads [dw/dt x r_i + w x (w x r_i)]_i more.
class AccelAxisOffset : public ImuEffect {
 public:
  AccelAxisOffset(const Eigen::Vector3d& r_y, const Eigen::Vector3d& r_z) : r_y_(r_y), r_z_(r_z) {}
  EffectTruth truth() const override;
  void on_imu(const ImuMoment& moment, ImuReading& reading) const override;

 private:
  Eigen::Vector3d r_y_, r_z_;  ///< m, in I
};

/// Change of the angular rate, rad/s^2, in I.
Eigen::Vector3d angular_acceleration(const Trajectory& truth, double t);

}  // namespace host::sim
