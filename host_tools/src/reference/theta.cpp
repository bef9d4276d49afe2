#include "reference/theta.h"

#include "reference/imu_residual.h"

namespace host::reference {
namespace {

/// How the printed numbers of a rotation move with a small turn Exp(d) R.
Eigen::Matrix3d rotation_vector_by_turn(const Eigen::Matrix3d& R) {
  using Jet = ceres::Jet<double, 3>;
  const Jet d[3] = {Jet(0, 0), Jet(0, 1), Jet(0, 2)};
  const Vector3<Jet> r = rotation_vector<Jet>(turned_by(d) * Eigen::Quaterniond(R).cast<Jet>());
  Eigen::Matrix3d J;
  for (int i = 0; i < 3; ++i) J.row(i) = r(i).v.transpose();
  return J;
}

}  // namespace

int lens_parameters(const CameraCalibration& camera) { return camera.model == DistortionModel::fov ? 1 : 4; }

int camera_parameters(const CameraCalibration& camera) { return 10 + lens_parameters(camera); }

Eigen::VectorXd theta_step(const Calibration& from, const Calibration& to) {
  std::vector<double> out;
  const auto put = [&out](const auto& v, int n) {
    for (int i = 0; i < n; ++i) out.push_back(v(i));
  };
  const auto turn = [](const Eigen::Matrix3d& a, const Eigen::Matrix3d& b) {
    return rotation_vector<double>(Eigen::Quaterniond(Eigen::Matrix3d(b * a.transpose())));
  };
  for (std::size_t c = 0; c < from.cameras.size(); ++c) {
    const CameraCalibration &a = from.cameras[c], &b = to.cameras[c];
    put(turn(a.R_CI, b.R_CI), 3);
    put(Eigen::Vector3d(b.p_CI - a.p_CI), 3);
    put(Eigen::Vector4d(b.intrinsics - a.intrinsics), 4);
    put(Eigen::Vector4d(b.distortion - a.distortion), camera_parameters(a) - 10);
  }
  double a[kImuSize], b[kImuSize];
  imu_block(from.imu, a);
  imu_block(to.imu, b);
  for (int i = 0; i < 12; ++i) out.push_back(b[i] - a[i]);
  put(turn(from.imu.R_AI, to.imu.R_AI), 3);
  return Eigen::Map<Eigen::VectorXd>(out.data(), static_cast<Eigen::Index>(out.size()));
}

Eigen::VectorXd printed_values(const Calibration& c) {
  Calibration zero = c;
  for (CameraCalibration& camera : zero.cameras) {
    camera.R_CI.setIdentity();
    camera.p_CI.setZero();
    camera.intrinsics.setZero();
    camera.distortion.setZero();
  }
  zero.imu.T_g.setZero();
  zero.imu.T_a.setZero();
  zero.imu.R_AI.setIdentity();
  return theta_step(zero, c);
}

Eigen::VectorXd printed_sigmas(const Calibration& theta, const Eigen::MatrixXd& covariance) {
  Eigen::VectorXd out = covariance.diagonal().cwiseSqrt();
  const auto rotation = [&](Eigen::Index first, const Eigen::Matrix3d& R) {
    const Eigen::Matrix3d J = rotation_vector_by_turn(R);
    out.segment<3>(first) = (J * covariance.block<3, 3>(first, first) * J.transpose()).diagonal().cwiseSqrt();
  };
  Eigen::Index first = 0;
  for (const CameraCalibration& c : theta.cameras) {
    rotation(first, c.R_CI);
    first += camera_parameters(c);
  }
  rotation(out.size() - 3, theta.imu.R_AI);
  return out;
}

std::string unit_of(const std::string& name) {
  const std::string last = name.substr(name.rfind('.') + 1);
  if (name.find(".r_") != std::string::npos) return "rad";
  if (name.find(".p_") != std::string::npos) return "m";
  return last == "fx" || last == "fy" || last == "cx" || last == "cy" ? "px" : "-";
}

}  // namespace host::reference
