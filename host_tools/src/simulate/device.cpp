#include "device.h"

#include <Eigen/Geometry>

#include "random.h"

namespace host::sim {
namespace {

Eigen::Matrix3d rotation_exp(const Eigen::Vector3d& v) {
  const double angle = v.norm();
  if (angle == 0) return Eigen::Matrix3d::Identity();
  return Eigen::AngleAxisd(angle, v / angle).toRotationMatrix();
}

Eigen::Vector3d rotation_log(const Eigen::Matrix3d& R) {
  const Eigen::AngleAxisd turn(R);
  return turn.angle() * turn.axis();
}

void set_lens(CameraCalibration& camera, DistortionModel model) {
  camera.model = model;
  camera.width = 640;
  camera.height = 480;
  camera.intrinsics = {256, 256, 319.5, 239.5};
  switch (model) {
    case DistortionModel::fov: camera.distortion = {0.92, 0, 0, 0}; break;
    case DistortionModel::equidistant: camera.distortion = {0.01, -0.008, 0.006, -0.002}; break;
    case DistortionModel::radtan:  // a global-shutter sensor behind a lens of about 80 degrees
      camera.width = 752;
      camera.intrinsics = {460, 460, 375.5, 239.5};
      camera.distortion = {-0.28, 0.07, 0, 0};
      break;
  }
}

/// The optical axis along x of I, the image's right along -y, its down along -z; then mounted a few degrees askew.
CameraCalibration nominal_camera(DistortionModel model, int index) {
  CameraCalibration camera;
  set_lens(camera, model);
  Eigen::Matrix3d R_axes;
  R_axes << 0, -1, 0,  //
      0, 0, -1,        //
      1, 0, 0;
  const double side = index == 0 ? 1 : -1;
  camera.R_CI = rotation_exp({0.08, -0.05 * side, 0.04}) * R_axes;
  const Eigen::Vector3d p_IC(0.035, 0.055 * side, -0.02);  // left or right of the IMU, m
  camera.p_CI = -camera.R_CI * p_IC;
  return camera;
}

/// Normal draws around nominal, all in units of the spread times `scale`.
class Draw {
 public:
  Draw(std::uint64_t seed, double scale) : random_(seed, Stream::device), scale_(scale) {}
  double operator()(double sigma) { return scale_ * sigma * random_.normal(); }
  Eigen::Vector3d three(double sigma) { return random_.normal3(scale_ * sigma); }

 private:
  Random random_;
  double scale_;
};

/// Does an equidistant lens reach the corners of the image, 89 degrees (1.56 rad) from the axis, without folding back?
/// Coefficients that scatter by themselves give lenses that fold back at 60 to 80 degrees, as no fisheye does: one in
/// four at scale 1.
bool reaches_the_corners(const CameraCalibration& camera) {
  const Eigen::Vector4d& k = camera.distortion;
  for (double theta = 0; theta < 1.56; theta += 0.02) {
    const double t2 = theta * theta;
    const double growth = 1 + t2 * (3 * k[0] + t2 * (5 * k[1] + t2 * (7 * k[2] + t2 * 9 * k[3])));
    if (growth < 0.2) return false;
  }
  return true;
}

void draw_lens(CameraCalibration& camera, const DeviceSpread& spread, Draw& draw) {
  const auto n = static_cast<Eigen::Index>(distortion_parameters(camera.model).size());
  for (Eigen::Index i = 0; i < n; ++i) {
    const bool is_tangential = camera.model == DistortionModel::radtan && i >= 2;
    const bool is_fov = camera.model == DistortionModel::fov;
    camera.distortion[i] += draw(is_fov ? spread.fov_w : is_tangential ? spread.distortion_p : spread.distortion_k);
  }
}

void draw_camera(CameraCalibration& camera, const DeviceSpread& spread, Draw& draw) {
  camera.R_CI = rotation_exp(draw.three(spread.rotation_rad)) * camera.R_CI;
  camera.p_CI += draw.three(spread.translation_m);
  for (int i = 0; i < 2; ++i) camera.intrinsics[i] += draw(spread.focal_length_px);
  for (int i = 2; i < 4; ++i) camera.intrinsics[i] += draw(spread.principal_point_px);
  const CameraCalibration nominal = camera;
  do {
    camera.distortion = nominal.distortion;
    draw_lens(camera, spread, draw);
  } while (camera.model == DistortionModel::equidistant && !reaches_the_corners(camera));
}

void draw_triangle(Eigen::Matrix3d& T, double scale_sigma, double misalignment_sigma, Draw& draw) {
  for (int i = 0; i < 3; ++i) T(i, i) += draw(scale_sigma);
  T(0, 1) += draw(misalignment_sigma);
  T(0, 2) += draw(misalignment_sigma);
  T(1, 2) += draw(misalignment_sigma);
}

void append(std::vector<NamedParameter>& list, const std::string& prefix, const std::vector<std::string>& names,
            const double* values) {
  for (std::size_t i = 0; i < names.size(); ++i) list.push_back({prefix + names[i], values[i]});
}

void append_camera(std::vector<NamedParameter>& list, const std::string& prefix, const CameraCalibration& camera) {
  append(list, prefix + "r_CI.", {"x", "y", "z"}, rotation_log(camera.R_CI).eval().data());
  append(list, prefix + "p_CI.", {"x", "y", "z"}, camera.p_CI.data());
  append(list, prefix, {"fx", "fy", "cx", "cy"}, camera.intrinsics.data());
  append(list, prefix, distortion_parameters(camera.model), camera.distortion.data());
}

void append_triangle(std::vector<NamedParameter>& list, const std::string& prefix, const Eigen::Matrix3d& T) {
  const double values[] = {T(0, 0), T(1, 1), T(2, 2), T(0, 1), T(0, 2), T(1, 2)};
  append(list, prefix, {"sx", "sy", "sz", "mx", "my", "mz"}, values);
}

}  // namespace

Calibration nominal_device(DistortionModel model, int n_cameras) {
  Calibration nominal;
  for (int i = 0; i < n_cameras; ++i) nominal.cameras.push_back(nominal_camera(model, i));
  return nominal;
}

Calibration draw_device(const Calibration& nominal, std::uint64_t device_seed, double scale) {
  const DeviceSpread spread;
  Draw draw(device_seed, scale);
  Calibration device = nominal;
  // The IMU first: a second camera then leaves the rest of the device as it is.
  draw_triangle(device.imu.T_g, spread.gyro_scale, spread.gyro_misalignment, draw);
  draw_triangle(device.imu.T_a, spread.accel_scale, spread.accel_misalignment, draw);
  device.imu.R_AI = rotation_exp(draw.three(spread.rotation_rad)) * device.imu.R_AI;
  for (CameraCalibration& camera : device.cameras) draw_camera(camera, spread, draw);
  return device;
}

std::vector<NamedParameter> named_parameters(const Calibration& calibration, bool with_imu) {
  std::vector<NamedParameter> list;
  for (std::size_t i = 0; i < calibration.cameras.size(); ++i)
    append_camera(list, "cam" + std::to_string(i) + ".", calibration.cameras[i]);
  if (!with_imu) return list;
  append_triangle(list, "gyro.", calibration.imu.T_g);
  append_triangle(list, "accel.", calibration.imu.T_a);
  append(list, "accel.r_AI.", {"x", "y", "z"}, rotation_log(calibration.imu.R_AI).eval().data());
  return list;
}

}  // namespace host::sim
