#include "device_log/logged_config.h"

#include <Eigen/Geometry>
#include <algorithm>

namespace host {
namespace {

struct Capacities {
  const char* profile;
  std::uint32_t numbers[kLoggedCapacities];  // as the header has them, from the size of a number on
};
constexpr Capacities kProfiles[] = {
    {"mcu", {4, 1, 8, 12, 40, 360, 426, 8, 40, 0, 8, 300, 1, 3, 6, 500, 16, 3, 0}},
    {"mobile", {4, 2, 15, 20, 120, 2000, 2000, 19, 160, 8, 8, 1000, 36, 42, 30, 0, 32, 4, 4}},
    {"host", {4, 2, 64, 32, 256, 6000, 8400, 19, 256, 16, 8, 2000, 64, 64, 30, 0, 32, 4, 4}},
    {"mobile_double", {8, 2, 15, 20, 120, 2000, 2000, 19, 160, 8, 8, 1000, 36, 42, 30, 0, 32, 4, 4}},
    // until 42 columns: how many can be asked about at once moves no bit of a result
    {"mobile", {4, 2, 15, 20, 120, 2000, 2000, 19, 160, 8, 8, 1000, 36, 36, 30, 0, 32, 4, 4}},
    {"mobile_double", {8, 2, 15, 20, 120, 2000, 2000, 19, 160, 8, 8, 1000, 36, 36, 30, 0, 32, 4, 4}}};

Eigen::Matrix3d rotation(const double* q) {
  const Eigen::Quaterniond rotation(q[0], q[1], q[2], q[3]);
  return rotation.norm() > 0 ? rotation.normalized().toRotationMatrix() : Eigen::Matrix3d(Eigen::Matrix3d::Identity());
}

Eigen::Matrix3d triangle(const double* scale, const double* misalignment) {
  const auto one = [](double s) { return s == 0 ? 1 : s; };
  Eigen::Matrix3d T;
  T << one(scale[0]), misalignment[0], misalignment[1], 0, one(scale[1]), misalignment[2], 0, 0, one(scale[2]);
  return T;
}

}  // namespace

std::string profile_of(const std::uint32_t* capacities, int n) {
  for (const Capacities& c : kProfiles) {
    if (std::equal(capacities, capacities + n, c.numbers)) return c.profile;
  }
  return "";
}

Calibration calibration_of(const segcal_config_t& c) {
  Calibration out;
  for (int i = 0; i < std::max(1, c.n_cameras); ++i) {
    CameraCalibration camera;
    camera.model = static_cast<DistortionModel>(c.camera[i].model);
    camera.R_CI = rotation(c.camera[i].q_CI);
    camera.p_CI = Eigen::Vector3d(c.camera[i].p_CI);
    camera.intrinsics = Eigen::Vector4d(c.camera[i].intrinsics);
    camera.distortion = Eigen::Vector4d(c.camera[i].distortion);
    camera.reads_columns = c.camera[i].height < 0;
    if (camera.reads_columns) {
      camera.width = -std::max(c.camera[i].height, -INT32_MAX);  // not checked yet: a damaged log may hold anything
    } else {
      camera.height = c.camera[i].height;
    }
    out.cameras.push_back(camera);
  }
  out.imu.T_g = triangle(c.imu.gyro_scale, c.imu.gyro_misalignment);
  out.imu.T_a = triangle(c.imu.accel_scale, c.imu.accel_misalignment);
  out.imu.R_AI = rotation(c.imu.q_AI);
  return out;
}

ImuNoise noise_of(const segcal_config_t& c) {
  ImuNoise out;
  const auto put = [](double value, double* to) {
    if (value > 0) *to = value;
  };
  put(c.imu_rate_hz, &out.rate_hz);
  put(c.gyro_noise_density, &out.gyro_noise_density);
  put(c.gyro_random_walk, &out.gyro_random_walk);
  put(c.accel_noise_density, &out.accel_noise_density);
  put(c.accel_random_walk, &out.accel_random_walk);
  return out;
}

}  // namespace host
