// The device: what its data sheet says (nominal), and what one specimen really is (drawn around nominal).
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "../calibration_file.h"

namespace host::sim {

/// How far devices scatter around nominal, one standard deviation each.
struct DeviceSpread {
  double focal_length_px = 1, principal_point_px = 1;
  double fov_w = 0.005, distortion_k = 0.005, distortion_p = 0.0005;
  double gyro_scale = 0.004, gyro_misalignment = 0.002;
  double accel_scale = 0.012, accel_misalignment = 0.012;
  double rotation_rad = 0.012;   ///< per axis, R_CI and R_AI
  double translation_m = 0.004;  ///< per axis, p_CI
};

/// Nominal device with one or two cameras, each looking along +x of the IMU.
Calibration nominal_device(DistortionModel model, int n_cameras);

/// A specimen: R <- Exp(d) R for the rotations, everything else nominal plus a normal draw.
/// `scale` multiplies the DeviceSpread; 0 gives the nominal device. An equidistant lens is drawn again until it reaches
/// the image's corners: one that folds back before is no fisheye.
Calibration draw_device(const Calibration& nominal, std::uint64_t device_seed, double scale);

/// One calibration parameter by its name in result files (docs/formats.md, "result.json"), SI units and px.
struct NamedParameter {
  std::string name;
  double value;
};

/// All parameters: cam0.*, cam1.*, then gyro.* and accel.*; rotations as rotation vectors.
std::vector<NamedParameter> named_parameters(const Calibration& calibration, bool with_imu);

}  // namespace host::sim
