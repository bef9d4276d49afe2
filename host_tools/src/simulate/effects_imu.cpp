#include "effects_imu.h"

#include <Eigen/Geometry>
#include <array>
#include <cmath>

#include "temperature.h"

namespace host::sim {
namespace {

/// Gauss and Laguerre with eight points: integral of exp(-x) g(x) from 0 to infinity, exact for g of degree 15.
constexpr std::array<double, 8> laguerre_x = {0.170279632305101, 0.903701776799380, 2.251086629866131,
                                              4.266700170287659, 7.045905402393466, 10.75851601018100,
                                              15.74067864127800, 22.86313173688926};
constexpr std::array<double, 8> laguerre_w = {3.69188589341638e-1, 4.18786780814343e-1, 1.75794986637172e-1,
                                              3.33434922612156e-2, 2.79453623522567e-3, 9.07650877335821e-5,
                                              8.48574671627253e-7, 1.04800117487151e-9};

constexpr double difference_step_s = 1e-4;  // truncation h^2/6 w''' below 1e-5 rad/s^2 for hand motion

EffectTruth axes(const char* name, const Eigen::Vector3d& k, const char* unit) {
  return {name, {{"x", k.x(), unit}, {"y", k.y(), unit}, {"z", k.z(), unit}}};
}

}  // namespace

Eigen::Vector3d angular_acceleration(const Trajectory& truth, double t) {
  return (truth.at(t + difference_step_s).w_GI - truth.at(t - difference_step_s).w_GI) / (2 * difference_step_s);
}

EffectTruth GyroGSensitivity::truth() const {
  EffectTruth out{"gyro_g_sensitivity", {}};
  const char axis[] = {'x', 'y', 'z'};
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column)
      out.parameters.push_back({std::string{axis[row], axis[column]}, T_gs_(row, column), "rad s/m"});
  return out;
}

void GyroGSensitivity::on_imu(const ImuMoment& moment, ImuReading& reading) const {
  reading.gyro += T_gs_ * moment.force_I;
}

EffectTruth GyroNonlinearity::truth() const { return axes("gyro_nonlinearity", k_, "s/rad"); }

void GyroNonlinearity::on_imu(const ImuMoment& moment, ImuReading& reading) const {
  const Eigen::Vector3d& w = moment.state.w_GI;
  for (int i = 0; i < 3; ++i) reading.gyro[i] += k_[i] * w[i] * std::abs(w[i]);
}

EffectTruth AccelNonlinearity::truth() const { return axes("accel_nonlinearity", k_, "s^2/m"); }

void AccelNonlinearity::on_imu(const ImuMoment& moment, ImuReading& reading) const {
  const Eigen::Vector3d f_A = moment.imu.R_AI * moment.force_I;
  reading.accel += k_.cwiseProduct(f_A.cwiseAbs2());
}

EffectTruth GyroTemperature::truth() const { return axes("gyro_temperature", k_, "rad/s/degC"); }

void GyroTemperature::on_imu(const ImuMoment& moment, ImuReading& reading) const {
  reading.gyro += k_ * (moment.temperature_degC - reference_temperature_degC);
}

EffectTruth AccelTemperature::truth() const { return axes("accel_temperature", k_, "m/s^2/degC"); }

void AccelTemperature::on_imu(const ImuMoment& moment, ImuReading& reading) const {
  reading.accel += k_ * (moment.temperature_degC - reference_temperature_degC);
}

/// The low-pass of w is the integral of exp(-s / tau) / tau w(t - s) over the past s.
void GyroLag::on_imu(const ImuMoment& moment, ImuReading& reading) const {
  Eigen::Vector3d late = Eigen::Vector3d::Zero();
  for (std::size_t k = 0; k < laguerre_x.size(); ++k)
    late += laguerre_w[k] * moment.truth.at(moment.t - tau_ * laguerre_x[k]).w_GI;
  reading.gyro += moment.imu.T_g * (late - moment.state.w_GI);
}

EffectTruth AccelAxisOffset::truth() const {
  return {"accel_axis_offset",
          {{"yx", r_y_.x(), "m"},
           {"yy", r_y_.y(), "m"},
           {"yz", r_y_.z(), "m"},
           {"zx", r_z_.x(), "m"},
           {"zy", r_z_.y(), "m"},
           {"zz", r_z_.z(), "m"}}};
}

void AccelAxisOffset::on_imu(const ImuMoment& moment, ImuReading& reading) const {
  const Eigen::Vector3d w = moment.state.w_GI, dw = angular_acceleration(moment.truth, moment.t);
  reading.accel.y() += (dw.cross(r_y_) + w.cross(w.cross(r_y_))).y();
  reading.accel.z() += (dw.cross(r_z_) + w.cross(w.cross(r_z_))).z();
}

}  // namespace host::sim
