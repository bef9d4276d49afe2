// The device that tests simulate: its data sheet, and how far real ones are from it.
#pragma once

#include <vector>

#include "sensors/calibration.h"

namespace test {

using namespace SEGCAL_NS;

inline Calibration<double> nominal_calibration(Distortion model) {
  Calibration<double> theta;
  CameraCalibration<double>& camera = theta.camera[0];
  camera.model = model;
  camera.intrinsics << 256, 256, 320, 240;
  camera.distortion.setZero();
  if (model == Distortion::fov) camera.distortion(0) = 0.92;
  if (model == Distortion::radtan) camera.distortion << -0.05, 0.01, 0, 0;
  if (model == Distortion::equidistant) camera.distortion << -0.01, 0.01, 0, 0;
  camera.R_CI << 0, -1, 0, 0, 0, -1, 1, 0, 0;
  camera.p_CI << 0.02, -0.03, 0.05;
  return theta;
}

/// Deviations of real devices from nominal, one standard deviation.
inline std::vector<double> device_sigmas(const Calibration<double>& theta) {
  std::vector<double> s;
  const auto put = [&s](int n, double value) { s.insert(s.end(), n, value); };
  put(3, 0.012);
  put(3, 0.004);
  put(4, 1.0);
  put(theta.camera[0].distortion_columns(), 0.004);
  put(3, 0.004);
  put(3, 0.002);
  put(9, 0.012);
  return s;
}

}  // namespace test
