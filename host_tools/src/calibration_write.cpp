// Writing a calibration in Kalibr's layout, so that the tools around Kalibr read it as their own.
#include "calibration_file.h"
#include "file_output.h"

namespace host {
namespace {

std::string list_of(const double* values, std::size_t count) {
  std::string text = "[";
  for (std::size_t i = 0; i < count; ++i) {
    if (i > 0) text += ", ";
    append_yaml_number(text, values[i]);
  }
  return text + "]";
}

/// `  NAME:` and one `  - [...]` line per row.
template <typename Matrix>
void append_matrix(std::string& text, const std::string& indent, const std::string& name, const Matrix& matrix) {
  text += indent + name + ":\n";
  for (Eigen::Index row = 0; row < matrix.rows(); ++row) {
    const Eigen::VectorXd values = matrix.row(row);
    text += indent + "- " + list_of(values.data(), static_cast<std::size_t>(values.size())) + "\n";
  }
}

Eigen::Matrix4d transform(const Eigen::Matrix3d& R, const Eigen::Vector3d& p) {
  Eigen::Matrix4d T = Eigen::Matrix4d::Identity();
  T.topLeftCorner<3, 3>() = R;
  T.topRightCorner<3, 1>() = p;
  return T;
}

void append_camera(std::string& text, std::size_t index, const CameraCalibration& camera) {
  const double resolution[] = {static_cast<double>(camera.width), static_cast<double>(camera.height)};
  text += "cam" + std::to_string(index) + ":\n";
  text += "  # p_cam = T_cam_imu p_imu and p_imu = T_imu_cam p_cam: a point in one frame, expressed in the other, m\n";
  append_matrix(text, "  ", "T_cam_imu", transform(camera.R_CI, camera.p_CI));
  append_matrix(text, "  ", "T_imu_cam", transform(camera.R_CI.transpose(), -camera.R_CI.transpose() * camera.p_CI));
  text += "  camera_model: pinhole\n";
  text += "  intrinsics: " + list_of(camera.intrinsics.data(), 4) + "  # fx fy cx cy, px\n";
  text += "  distortion_model: " + distortion_name(camera.model) + "\n";
  text +=
      "  distortion_coeffs: " + list_of(camera.distortion.data(), distortion_parameters(camera.model).size()) + "\n";
  if (camera.width > 0 && camera.height > 0) text += "  resolution: " + list_of(resolution, 2) + "\n";
  if (camera.reads_columns) text += "  readout: columns  # a rolling shutter exposes column after column\n";
  text += "  rostopic: /cam" + std::to_string(index) + "/image_raw\n";
  text += "  # t_imu = t_cam + timeshift_cam_imu, s\n  timeshift_cam_imu: ";
  append_yaml_number(text, camera.timeshift_cam_imu);
  text += '\n';
}

}  // namespace

void write_camchain(const std::filesystem::path& file, const Calibration& calibration) {
  std::string text;
  for (std::size_t i = 0; i < calibration.cameras.size(); ++i) append_camera(text, i, calibration.cameras[i]);
  write_file(file, text);
}

void write_imu_yaml(const std::filesystem::path& file, const Calibration& calibration, const ImuNoise& noise) {
  std::string text = "rostopic: /imu0\n";
  append_yaml_entry(text, "update_rate", noise.rate_hz, "Hz");
  append_yaml_entry(text, "accelerometer_noise_density", noise.accel_noise_density, "m/s^2/sqrt(Hz)");
  append_yaml_entry(text, "accelerometer_random_walk", noise.accel_random_walk, "m/s^3/sqrt(Hz)");
  append_yaml_entry(text, "gyroscope_noise_density", noise.gyro_noise_density, "rad/s/sqrt(Hz)");
  append_yaml_entry(text, "gyroscope_random_walk", noise.gyro_random_walk, "rad/s^2/sqrt(Hz)");
  text += "model: scale-misalignment\n";
  text += "# measurement = M C x + bias, x in the frame of the IMU (the gyroscope's), C_gyro_i the identity\n";
  text += "gyroscopes:\n";
  append_matrix(text, "  ", "M", calibration.imu.T_g);
  append_matrix(text, "  ", "C_gyro_i", Eigen::Matrix3d::Identity());
  text += "accelerometers:\n";
  append_matrix(text, "  ", "M", calibration.imu.T_a);
  append_matrix(text, "  ", "C_accel_i", calibration.imu.R_AI);
  write_file(file, text);
}

}  // namespace host
