// Reading a calibration: Kalibr's camchain-imucam.yaml with imu.yaml beside it, or EuRoC's sensor.yaml per camera.
#include <Eigen/Geometry>

#include "calibration_file.h"
#include "device_log/device_log.h"
#include "formatted.h"
#include "imu_model_file.h"
#include "yaml_file.h"

namespace host {
namespace {

namespace fs = std::filesystem;
using Eigen::Isometry3d;

constexpr double most_pixels = 65535;

/// Image size, intrinsics and distortion have the same names in both layouts.
CameraCalibration read_projection(const YamlFile& yaml, const YAML::Node& node) {
  CameraCalibration camera;
  if (yaml.text(node, "camera_model") != "pinhole") yaml.fail(node["camera_model"], "camera_model: pinhole");
  try {
    camera.model = distortion_from_name(yaml.text(node, "distortion_model"));
  } catch (const InputError& error) {
    if (node["distortion_model"].IsDefined()) yaml.fail(node["distortion_model"], error.what());
    throw;
  }
  if (node["resolution"].IsDefined()) {  // a device log does not know it
    const auto resolution = yaml.numbers(node, "resolution", 2);
    for (const double size : resolution)
      if (!(size >= 1 && size <= most_pixels))
        yaml.fail(node["resolution"], "resolution: [width, height] in pixels, 1 to 65535");
    camera.width = static_cast<int>(resolution[0]);
    camera.height = static_cast<int>(resolution[1]);
  }

  if (node["readout"].IsDefined()) {
    try {
      camera.reads_columns = reads_columns(yaml.text(node, "readout"));
    } catch (const InputError& error) {
      yaml.fail(node["readout"], error.what());
    }
  }

  const auto intrinsics = yaml.numbers(node, "intrinsics", 4);
  camera.intrinsics = Eigen::Map<const Eigen::Vector4d>(intrinsics.data());
  if (!(intrinsics[0] > 0 && intrinsics[1] > 0)) yaml.fail(node["intrinsics"], "focal lengths above 0 px");

  // Kalibr and EuRoC differ in this name only.
  const char* const coefficients =
      node["distortion_coeffs"].IsDefined() ? "distortion_coeffs" : "distortion_coefficients";
  const std::size_t count = distortion_parameters(camera.model).size();
  const auto distortion = yaml.numbers(node, coefficients, count);
  for (std::size_t i = 0; i < count; ++i) camera.distortion[static_cast<Eigen::Index>(i)] = distortion[i];
  return camera;
}

void set_extrinsics(CameraCalibration& camera, const Isometry3d& T_CI) {
  camera.R_CI = T_CI.linear();
  camera.p_CI = T_CI.translation();
}

Isometry3d extrinsics(const CameraCalibration& camera) {
  Isometry3d T_CI = Isometry3d::Identity();
  T_CI.linear() = camera.R_CI;
  T_CI.translation() = camera.p_CI;
  return T_CI;
}

/// Kalibr gives T_cam_imu, sometimes only its inverse, and for a second camera sometimes only the step from the first.
Isometry3d read_kalibr_extrinsics(const YamlFile& yaml, const YAML::Node& node,
                                  const std::vector<CameraCalibration>& before) {
  if (node["T_cam_imu"].IsDefined()) return Isometry3d(yaml.transform(node, "T_cam_imu"));
  if (node["T_imu_cam"].IsDefined()) return Isometry3d(yaml.transform(node, "T_imu_cam")).inverse();
  if (node["T_cn_cnm1"].IsDefined() && !before.empty())
    return Isometry3d(yaml.transform(node, "T_cn_cnm1")) * extrinsics(before.back());
  yaml.fail(node, "an entry 'T_cam_imu' here");
}

CameraCalibration read_euroc_camera(const fs::path& file, const Isometry3d& T_BI) {
  return read_yaml(file, [&T_BI](const YamlFile& yaml) {
    CameraCalibration camera = read_projection(yaml, yaml.root());
    const Isometry3d T_BC(yaml.transform(yaml.root(), "T_BS"));
    set_extrinsics(camera, T_BC.inverse() * T_BI);
    return camera;
  });
}

/// EuRoC's body frame is the IMU's, but the file may say otherwise.
Isometry3d read_euroc_imu_pose(const fs::path& file) {
  if (!fs::exists(file)) return Isometry3d::Identity();
  return read_yaml(file, [](const YamlFile& yaml) {
    if (!yaml.root()["T_BS"].IsDefined()) return Isometry3d::Identity();
    return Isometry3d(yaml.transform(yaml.root(), "T_BS"));
  });
}

Calibration read_euroc_sensors(const fs::path& root, int n_cameras) {
  Calibration calibration;
  const Isometry3d T_BI = read_euroc_imu_pose(root / "mav0" / "imu0" / "sensor.yaml");
  for (int i = 0; i < n_cameras; ++i) {
    const fs::path file = root / "mav0" / ("cam" + std::to_string(i)) / "sensor.yaml";
    if (!fs::exists(file))
      throw InputError((root / "camchain-imucam.yaml").string() + ": file is missing: expected it, or " +
                       file.string() + ", or --calib FILE");
    calibration.cameras.push_back(read_euroc_camera(file, T_BI));
  }
  return calibration;
}

/// m; what is farther from the IMU was not stated in metres, or is another transformation.
constexpr double kFarthestCamera = 20;

void expect_metres(const Calibration& calibration, const fs::path& file) {
  for (std::size_t i = 0; i < calibration.cameras.size(); ++i) {
    const double far = calibration.cameras[i].p_CI.norm();
    if (far > kFarthestCamera)
      throw InputError(file.string() + ": cam" + std::to_string(i) +
                       ": expected T_cam_imu with its translation in m, found " +
                       formatted("a camera %.0f m from the IMU", far));
  }
}

/// The first camera chain of the places where it may lie; empty if there is none.
fs::path find_camchain(const fs::path& root, const fs::path& override_file) {
  if (!override_file.empty()) return override_file;
  for (const fs::path& file : {root / "camchain-imucam.yaml", root / "dso" / "camchain.yaml"})
    if (fs::exists(file)) return file;
  return {};
}

}  // namespace

namespace {

Calibration read_cameras(const YamlFile& yaml) {
  Calibration calibration;
  for (int i = 0;; ++i) {
    const YAML::Node node = yaml.root()["cam" + std::to_string(i)];
    if (!node.IsDefined()) break;
    CameraCalibration camera = read_projection(yaml, node);
    set_extrinsics(camera, read_kalibr_extrinsics(yaml, node, calibration.cameras));
    camera.timeshift_cam_imu = yaml.number_or(node, "timeshift_cam_imu", 0);
    calibration.cameras.push_back(camera);
  }
  if (calibration.cameras.empty()) yaml.fail(yaml.root(), "an entry 'cam0' here");
  return calibration;
}

}  // namespace

Calibration read_calibration(const fs::path& camchain) {
  Calibration calibration = read_yaml(camchain, read_cameras);
  const fs::path imu_file = camchain.parent_path() / "imu.yaml";
  if (fs::exists(imu_file)) read_imu_model(imu_file, calibration);
  return calibration;
}

Calibration find_calibration(const fs::path& root, const fs::path& override_file, int n_cameras) {
  const fs::path camchain = find_camchain(root, override_file);
  const bool log = camchain.empty() && is_device_log(root);
  Calibration calibration = log                ? read_device_log(root).calibration
                            : camchain.empty() ? read_euroc_sensors(root, n_cameras)
                                               : read_calibration(camchain);
  if (static_cast<int>(calibration.cameras.size()) < n_cameras)
    throw InputError((log ? root : camchain).string() + ":1: expected an entry 'cam" +
                     std::to_string(calibration.cameras.size()) + "', one for each of " + std::to_string(n_cameras) +
                     " cameras");
  calibration.cameras.resize(static_cast<std::size_t>(n_cameras));
  expect_metres(calibration, camchain.empty() ? root : camchain);
  return calibration;
}

}  // namespace host
