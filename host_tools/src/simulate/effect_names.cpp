#include "effect_names.h"

#include "angles.h"
#include "effect_values.h"
#include "effects_camera.h"
#include "effects_imu.h"
#include "effects_log.h"
#include "effects_outside.h"
#include "effects_variance.h"
#include "effects_wandering.h"
#include "exposures.h"

namespace host::sim {
namespace {

using effect_values::number, effect_values::numbers, effect_values::positive, effect_values::three;
using effect_values::Values, effect_values::expect, effect_values::split;
using Made = std::shared_ptr<const Effect>;

/// One value is the factor of both sensors.
Made make_imu_noise(const Values& v) {
  expect(v, 1, 2);
  return std::make_shared<NoiseFactor>(NoiseFactors{positive(v[0]), positive(v.back()), 1});
}

Made make_pixel_noise(const Values& v) {
  expect(v, 1, 1);
  return std::make_shared<NoiseFactor>(NoiseFactors{1, 1, positive(v[0])});
}

Made make_g_sensitivity(const Values& v) {
  expect(v, 9, 9);
  Eigen::Matrix3d T_gs;
  for (std::size_t i = 0; i < 9; ++i)
    T_gs(static_cast<Eigen::Index>(i / 3), static_cast<Eigen::Index>(i % 3)) = number(v[i]);
  return std::make_shared<GyroGSensitivity>(T_gs);
}

Made make_axis_offset(const Values& v) {
  expect(v, 6, 6);
  const std::vector<double> r = numbers(v);
  return std::make_shared<AccelAxisOffset>(Eigen::Vector3d(r[0], r[1], r[2]), Eigen::Vector3d(r[3], r[4], r[5]));
}

Made make_shift(const Values& v) {
  expect(v, 3, 5);
  return std::make_shared<CalibrationShift>(v[0], number(v[1]), numbers(v, 2));
}

Made log_fault(EffectTruth truth, LogFault::Disturbance disturbance) {
  return std::make_shared<LogFault>(std::move(truth), std::move(disturbance));
}

Made make_saturation(const Values& v) {
  expect(v, 2, 2);
  const double gyro = number(v[0]), accel = number(v[1]);
  return log_fault({"saturation", {{"gyro", gyro, "rad/s"}, {"accel", accel, "m/s^2"}}},
                   [=](Recording& r, std::uint64_t) { disturb::clip(r, gyro, accel); });
}

Made make_dropped(const Values& v) {
  expect(v, 1, 1);
  const double n = positive(v[0]);
  if (n < 2 || n > 1e6) throw InputError("expected 2 to 1000000, found '" + v[0] + "'");
  return log_fault({"dropped_samples", {{"every", n, "samples"}}},
                   [n](Recording& r, std::uint64_t) { disturb::drop_imu_samples(r, static_cast<int>(n)); });
}

Made make_jitter(const Values& v) {
  expect(v, 1, 2);
  const double imu = number(v[0]), camera = v.size() > 1 ? number(v[1]) : 0;
  return log_fault({"stamp_jitter", {{"imu", imu, "s"}, {"camera", camera, "s"}}},
                   [=](Recording& r, std::uint64_t seed) { disturb::jitter_stamps(r, imu, camera, seed); });
}

disturb::Sensor sensor_of(const std::string& name) {
  if (name != "gyro" && name != "accel") throw InputError("expected gyro or accel, found '" + name + "'");
  return name == "gyro" ? disturb::Sensor::gyro : disturb::Sensor::accel;
}

Made make_frozen(const Values& v) {
  expect(v, 3, 3);
  const disturb::Sensor sensor = sensor_of(v[0]);
  const double t = number(v[1]), seconds = positive(v[2]);
  return log_fault(
      {"frozen", {{v[0] + ".time", t, "s"}, {v[0] + ".duration", seconds, "s"}}}, [=](Recording& r, std::uint64_t) {
        if (!r.imu.samples.empty())
          disturb::freeze(r, sensor, r.imu.samples.front().t_ns + static_cast<std::int64_t>(t * 1e9), seconds);
      });
}

Made make_unit(const Values& v) {
  expect(v, 1, 1);
  const disturb::Sensor sensor = sensor_of(v[0]);
  const double factor = sensor == disturb::Sensor::gyro ? deg_per_rad : 1 / 9.80665;
  return log_fault({"unit", {{v[0], factor, "-"}}},
                   [=](Recording& r, std::uint64_t) { disturb::scale(r, sensor, Eigen::Vector3d::Constant(factor)); });
}

Made make_axes(const Values& v) {
  expect(v, 2, 2);
  const disturb::Sensor sensor = sensor_of(v[0]);
  Recording none;
  disturb::reorder_axes(none, sensor, v[1]);  // complains about a wrong text now rather than later
  return log_fault({"axes:" + v[0] + ":" + v[1], {}},
                   [sensor, axes = v[1]](Recording& r, std::uint64_t) { disturb::reorder_axes(r, sensor, axes); });
}

Made make_clock(const Values& v) {
  expect(v, 1, 2);
  const double drift = number(v[0]), shift = v.size() > 1 ? number(v[1]) : 0;
  return log_fault({"clock_drift", {{"drift", drift, "s/s"}, {"shift", shift, "s"}}},
                   [=](Recording& r, std::uint64_t) { disturb::shift_camera_stamps(r, shift, drift); });
}

template <class E>
Made make_three(const Values& v) {
  return std::make_shared<E>(three(v));
}

template <class E>
Made make_one(const Values& v) {
  expect(v, 1, 1);
  return std::make_shared<E>(number(v[0]));
}

Made make_tangential(const Values& v) {
  expect(v, 2, 2);
  return std::make_shared<TangentialResidual>(number(v[0]), number(v[1]));
}

Made make_camera_temperature(const Values& v) {
  expect(v, 6, 6);
  return std::make_shared<CameraTemperature>(three({v[0], v[1], v[2]}), number(v[3]),
                                             Eigen::Vector2d(number(v[4]), number(v[5])));
}

Made make_exposure_offset(const Values& v) {
  expect(v, 1, 1);
  const double kappa = number(v[0]);
  if (!(kappa >= -1 && kappa <= 1)) throw InputError("expected -1 to 1, found '" + v[0] + "'");
  return std::make_shared<ExposureOffset>(kappa);
}

Made make_lag(const Values& v) {
  expect(v, 1, 1);
  const double tau = number(v[0]);
  if (!(tau >= 0 && tau <= 0.1)) throw InputError("expected 0 to 0.1 s, found '" + v[0] + "'");
  return std::make_shared<GyroLag>(tau);
}

Made make_noise_with_motion(const Values& v) {
  expect(v, 2, 2);
  return std::make_shared<NoiseWithMotion>(number(v[0]), number(v[1]));
}

Made make_decentred(const Values& v) {
  expect(v, 3, 3);
  return std::make_shared<DecentredDistortion>(number(v[0]), number(v[1]), number(v[2]));
}

}  // namespace

const std::vector<EffectEntry>& effect_entries() {
  using K = EffectKind;
  // Each effect on one line where it fits.
  // clang-format off
  static const std::vector<EffectEntry> all = {
      {K::catalogue, "time_offset", "t_d [s]: t_imu = t_cam + t_d", "0.003", make_one<TimeOffset>},
      {K::catalogue, "rolling_shutter", "line_delay [s/row]", "15e-6", make_one<RollingShutter>},
      {K::catalogue, "radial_residual", "k [-]", "0.003", make_one<RadialResidual>},
      {K::catalogue, "tangential_residual", "p1,p2 [-]", "0.001,0", make_tangential},
      {K::catalogue, "gyro_g_sensitivity", "xx,xy,xz,yx,yy,yz,zx,zy,zz [rad s/m], gyroscope axis and force axis",
       "3e-4,0,0,0,3e-4,0,0,0,3e-4", make_g_sensitivity},
      {K::catalogue, "gyro_nonlinearity", "x,y,z [s/rad]: + k w |w|", "2e-3,0,0", make_three<GyroNonlinearity>},
      {K::catalogue, "accel_nonlinearity", "x,y,z [s^2/m]: + k f^2", "1e-3,0,0", make_three<AccelNonlinearity>},
      {K::catalogue, "gyro_temperature", "x,y,z [rad/s/degC] from 25 degC", "3e-4,0,0", make_three<GyroTemperature>},
      {K::catalogue, "accel_temperature", "x,y,z [m/s^2/degC] from 25 degC", "5e-3,0,0", make_three<AccelTemperature>},
      {K::catalogue, "gyro_lag", "tau [s]: first-order low-pass", "0.004", make_lag},
      {K::catalogue, "accel_axis_offset", "yx,yy,yz,zx,zy,zz [m], places of the y and z accelerometers from x's", "0.01,0,0,0,0.01,0", make_axis_offset},
      {K::catalogue, "camera_temperature", "rx,ry,rz,f,cx,cy [1/degC] from 25 degC: turn [rad], share of f, centre in focal lengths", "1e-4,0,0,1e-4,0,0", make_camera_temperature},
      {K::catalogue, "exposure_offset", "kappa [-]: t_imu = t_cam + kappa exposure; exposures of 2 to 20 ms", "0.5", make_exposure_offset},
      {K::catalogue, "imu_noise", "factor(,factor of the accelerometer) [-] on the stated noise", "3", make_imu_noise},
      {K::catalogue, "pixel_noise", "factor [-] on --pixel-noise", "2", make_pixel_noise},
      {K::catalogue, "calibration_shift",
       "BLOCK,time [s],step: from then on. cam0.r_CI [rad], cam0.p_CI [m], cam0.f, cam0.c [px], gyro.s, gyro.m, accel.s, accel.m [-], accel.r_AI [rad]",
       "cam0.r_CI,30,0.012,0,0", make_shift},
      {K::catalogue, "saturation", "gyro [rad/s],accel [m/s^2], 0: none", "2,14", make_saturation},
      {K::catalogue, "dropped_samples", "n: every n-th IMU sample is missing", "50", make_dropped},
      {K::catalogue, "stamp_jitter", "IMU(,camera) [s], standard deviation", "0.001", make_jitter},
      {K::fault, "frozen", "gyro|accel,time [s],duration [s]: repeats its reading", "gyro,20,2", make_frozen},
      {K::fault, "unit", "gyro: deg/s, accel: g", "gyro", make_unit},
      {K::fault, "axes", "gyro|accel,order such as yxz or x-yz", "gyro,yxz", make_axes},
      {K::fault, "clock_drift", "drift [s/s](,shift [s]) of the camera's clock", "1e-4", make_clock},
      {K::outside, "outside:gyro_hysteresis", "width [rad/s] of the play", "0.01", make_one<GyroHysteresis>},
      {K::outside, "outside:vibration_rectification", "k [s^2/m] times the variance of the force over 0.5 s", "0.02", make_one<VibrationRectification>},
      {K::outside, "outside:attitude_error", "k [m/s^2] times sin 2 roll, sin 2 pitch", "0.1", make_one<AttitudeError>},
      {K::outside, "outside:heading_error", "k [rad/s] times cos yaw, sin yaw, sin 2 yaw", "0.01", make_one<HeadingError>},
      {K::outside, "outside:noise_with_motion", "gyro,accel [s/rad]: white noise beside the stated one, so many times it for each rad/s", "1,4", make_noise_with_motion},
      {K::outside, "outside:decentred_distortion", "k,cx,cy [-]: k r^6 about (cx, cy)", "0.02,0.2,-0.1", make_decentred},
      {K::outside, "outside:focus_hunting", "k [-]: f (1 + k sin(2 pi t / 7 s))", "0.002", make_one<FocusHunting>},
      {K::outside, "outside:loose_mount", "angle [rad] to either side, drawn every 1.7 s", "0.002", make_one<LooseMount>},
      {K::outside, "outside:wandering_stamps", "k [s] times sin(2 pi t / 11 s)", "0.001", make_one<WanderingStamps>},
      {K::outside, "outside:gyro_hum", "k [rad/s] of a tone at 1.3 Hz", "0.005", make_one<GyroHum>},
      {K::outside, "outside:two_way_shutter", "k [s/row] from the middle row to both edges", "5e-6", make_one<TwoWayShutter>},
  };
  // clang-format on
  return all;
}

std::shared_ptr<const Effect> parse_effect(const std::string& text) {
  const std::size_t equals = text.find('=');
  const std::string name = text.substr(0, equals);
  for (const EffectEntry& entry : effect_entries()) {
    if (name != entry.name) continue;
    if (equals == std::string::npos) throw InputError(text + ": expected " + name + "=" + entry.values);
    try {
      return entry.make(split(text.substr(equals + 1)));
    } catch (const InputError& error) {
      throw InputError(text + ": " + error.what() + "; values are " + entry.values);
    }
  }
  throw InputError("expected one of the effects in segcal simulate --help, found '" + name + "'");
}

std::string effect_help(EffectKind kind) {
  std::string text;
  for (const EffectEntry& entry : effect_entries()) {
    if (entry.kind != kind) continue;
    text += std::string("  ") + entry.name + "=" + entry.example + "\n      " + entry.values + "\n";
  }
  return text;
}

}  // namespace host::sim
