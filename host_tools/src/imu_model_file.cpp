#include "imu_model_file.h"

#include <Eigen/Dense>

#include "yaml_file.h"

namespace host {
namespace {

/// M and C of one sensor triad; `A` is their product.
struct Triad {
  Eigen::Matrix3d M = Eigen::Matrix3d::Identity();
  Eigen::Matrix3d C = Eigen::Matrix3d::Identity();
};

Triad read_triad(const YamlFile& yaml, const YAML::Node& imu, const char* group, const char* rotation) {
  Triad triad;
  const YAML::Node node = imu[group];
  if (!node.IsDefined()) return triad;
  if (node["M"].IsDefined()) triad.M = yaml.matrix3(node, "M");
  if (node[rotation].IsDefined()) triad.C = yaml.matrix3(node, rotation);
  const double error = (triad.C * triad.C.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  if (error > 1e-3 || triad.C.determinant() < 0)
    yaml.fail(node[rotation], std::string("a rotation for '") + rotation + "'");
  if ((triad.M.diagonal().array() <= 0).any() || triad.M.determinant() <= 0)
    yaml.fail(node["M"], "a matrix M with positive scales on its diagonal");
  return triad;
}

/// Files that segcal wrote come back digit for digit: no factorisation where M already has the wanted form.
ScaleAndRotation in_segcal_form(const Triad& triad) {
  if (triad.M.isUpperTriangular(0)) return {triad.M, triad.C};
  return split_scale_and_rotation(triad.M * triad.C);
}

}  // namespace

ScaleAndRotation split_scale_and_rotation(const Eigen::Matrix3d& A) {
  // RQ by way of QR: with P the reversal of order, (P A)^T = Q U gives A = (P U^T P) (P Q^T).
  const Eigen::Matrix3d P = Eigen::Matrix3d::Identity().rowwise().reverse();
  const Eigen::HouseholderQR<Eigen::Matrix3d> qr((P * A).transpose());
  const Eigen::Matrix3d Q = qr.householderQ();
  const Eigen::Matrix3d U = qr.matrixQR().triangularView<Eigen::Upper>();
  const Eigen::Matrix3d T = P * U.transpose() * P;
  const Eigen::Vector3d signs = T.diagonal().array().sign();
  return {T * signs.asDiagonal(), signs.asDiagonal() * (P * Q.transpose())};
}

void read_imu_model(const std::filesystem::path& file, Calibration& calibration) {
  read_yaml(file, [&calibration](const YamlFile& yaml) {
    const YAML::Node imu = yaml.root()["imu0"].IsDefined() ? yaml.root()["imu0"] : yaml.root();
    const ScaleAndRotation gyro = in_segcal_form(read_triad(yaml, imu, "gyroscopes", "C_gyro_i"));
    Triad accel = read_triad(yaml, imu, "accelerometers", "C_accel_i");

    // gyro.R turns Kalibr's body frame into the gyroscope's, which is I: everything else is expressed in I now.
    if (!gyro.R.isIdentity(0)) {
      accel.C = accel.C * gyro.R.transpose();
      for (CameraCalibration& camera : calibration.cameras) camera.R_CI = camera.R_CI * gyro.R.transpose();
    }
    const ScaleAndRotation accelerometer = in_segcal_form(accel);
    calibration.imu.T_g = gyro.T;
    calibration.imu.T_a = accelerometer.T;
    calibration.imu.R_AI = accelerometer.R;
  });
}

}  // namespace host
