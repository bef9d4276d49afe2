// Calibration on disk in Kalibr's layout: camchain-imucam.yaml and imu.yaml; also EuRoC's sensor.yaml (T_BS).
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

#include "recording.h"

namespace host {

enum class DistortionModel { fov, radtan, equidistant };

/// Names as in Kalibr's files: "fov", "radtan" (also
/// "radial-tangential"), "equidistant" (also "equi"). Throws InputError.
DistortionModel distortion_from_name(const std::string& name);
std::string distortion_name(DistortionModel model);
/// Names of the coefficients: {"w"}, {"k1","k2","p1","p2"}, {"k1","k2","k3","k4"}.
std::vector<std::string> distortion_parameters(DistortionModel model);

/// What a rolling shutter exposes one after another, "rows" or "columns". Throws InputError.
bool reads_columns(const std::string& readout);

struct CameraCalibration {
  DistortionModel model = DistortionModel::radtan;
  int width = 0, height = 0;                             ///< px
  Eigen::Vector4d intrinsics = Eigen::Vector4d::Zero();  ///< fx fy cx cy, px
  Eigen::Vector4d distortion = Eigen::Vector4d::Zero();  ///< first distortion_parameters().size() entries are used
  Eigen::Matrix3d R_CI = Eigen::Matrix3d::Identity();    ///< rotates a vector in I into C
  Eigen::Vector3d p_CI = Eigen::Vector3d::Zero();        ///< p_C = R_CI p_I + p_CI, m (Kalibr's T_cam_imu)
  double timeshift_cam_imu = 0;                          ///< s, t_imu = t_cam + shift
  bool reads_columns = false;                            ///< a rolling shutter exposes column after column, not rows

  /// Of a rolling shutter, px: how many there are, and on which one a pixel lies.
  int lines() const { return reads_columns ? width : height; }
  double line_of(const Eigen::Vector2d& pixel) const { return reads_columns ? pixel.x() : pixel.y(); }
};

/// w_m = T_g w + b_g, a_m = T_a R_AI f_I + b_a; T = [[sx, mx, my], [0, sy, mz], [0, 0, sz]].
struct ImuCalibration {
  Eigen::Matrix3d T_g = Eigen::Matrix3d::Identity();
  Eigen::Matrix3d T_a = Eigen::Matrix3d::Identity();
  Eigen::Matrix3d R_AI = Eigen::Matrix3d::Identity();  ///< rotates a vector in I into the accelerometer's axes
};

struct Calibration {
  std::vector<CameraCalibration> cameras;
  ImuCalibration imu;
};

/// Reads a camchain-imucam.yaml; where a file `imu.yaml` with M
/// matrices lies beside it, the IMU part too. Throws InputError.
Calibration read_calibration(const std::filesystem::path& camchain);

/// The starting calibration of a recording: --calib FILE, else REC/camchain-imucam.yaml, else camN/sensor.yaml (EuRoC).
Calibration find_calibration(const std::filesystem::path& recording_root, const std::filesystem::path& override_file,
                             int n_cameras);

/// Writes Kalibr's layout, both directions of each transform
/// (T_cam_imu and T_imu_cam) and the time shift's sign in a comment.
void write_camchain(const std::filesystem::path& file, const Calibration& calibration);
/// Writes imu.yaml: noise densities, update_rate, accelerometers/gyroscopes {M, C}. Kalibr's names.
void write_imu_yaml(const std::filesystem::path& file, const Calibration& calibration, const ImuNoise& noise);

}  // namespace host
