#include "reference/link_covariance.h"

#include <Eigen/LU>

namespace host::reference {
namespace {

/// Skew matrix of the cross product.
Eigen::Matrix3d crossing(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

Eigen::Matrix3d triangle(const double* s, const double* m) {
  Eigen::Matrix3d T;
  T << s[0], m[0], m[1], 0, s[1], m[2], 0, 0, s[2];
  return T;
}

}  // namespace

ErrorModel::ErrorModel(const CoreModel& model, const LinkNoise& white, const double* inputs,
                       const Eigen::Matrix3d& R_AI) {
  rate_by_bias = -triangle(inputs + 6, inputs + 9).inverse();
  force_by_bias = -(R_AI.transpose() * triangle(inputs + 12, inputs + 15).inverse());
  gyro2.setConstant(white.gyro * white.gyro);
  accel2.setConstant(white.accel * white.accel);
  for (int i = 0; i < 3; ++i) {
    noise(9 + i, 9 + i) = model.accel_random_walk * model.accel_random_walk;
    noise(12 + i, 12 + i) = model.gyro_random_walk * model.gyro_random_walk;
  }
}

ErrorModel ErrorModel::of_axis(int k) const {
  ErrorModel out = *this;
  out.noise.setZero();
  for (int i = 0; i < 3; ++i) {
    if (i != k) out.gyro2(i) = 0;
    if (3 + i != k) out.accel2(i) = 0;
  }
  return out;
}

LinkMatrix ErrorModel::slope(const LinkMatrix& P, const Eigen::Matrix3d& R, const Eigen::Vector3d& w,
                             const Eigen::Vector3d& f) const {
  LinkMatrix A = LinkMatrix::Zero(), Q = noise;
  A.block<3, 3>(0, 0) = -crossing(w);
  A.block<3, 3>(0, 12) = rate_by_bias;
  A.block<3, 3>(3, 0) = -R * crossing(f);
  A.block<3, 3>(3, 9) = R * force_by_bias;
  A.block<3, 3>(6, 3).setIdentity();
  Q.block<3, 3>(0, 0) = rate_by_bias * gyro2.asDiagonal() * rate_by_bias.transpose();
  Q.block<3, 3>(3, 3) = A.block<3, 3>(3, 9) * accel2.asDiagonal() * A.block<3, 3>(3, 9).transpose();
  const LinkMatrix AP = A * P;
  return AP + AP.transpose() + Q;
}

LinkMatrix covariance(const std::vector<Step>& steps, const Sensor<double>& sensor, const ErrorModel& errors) {
  Integral<double> x;
  LinkMatrix P = LinkMatrix::Zero();
  for (const Step& step : steps) {
    const double h = step.h;
    const auto w = [&](int k) { return sensor.rate(step.gyro[k]); };
    const auto f = [&](int k) { return sensor.force(step.accel[k]); };
    const Eigen::Matrix3d R0 = x.q.toRotationMatrix();
    const Eigen::Vector3d middle_turn = 0.25 * h * (w(0) + w(1));
    const Eigen::Matrix3d R1 = R0 * turned_by(middle_turn.data()).toRotationMatrix();
    integrate(step, sensor, &x);
    const Eigen::Matrix3d R2 = x.q.toRotationMatrix();
    const LinkMatrix k1 = errors.slope(P, R0, w(0), f(0)), k2 = errors.slope(P + 0.5 * h * k1, R1, w(1), f(1));
    const LinkMatrix k3 = errors.slope(P + 0.5 * h * k2, R1, w(1), f(1)), k4 = errors.slope(P + h * k3, R2, w(2), f(2));
    P += (h / 6) * (k1 + 2 * (k2 + k3) + k4);
  }
  return P;
}

}  // namespace host::reference
