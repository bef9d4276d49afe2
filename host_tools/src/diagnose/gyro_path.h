// Rotation that a gyroscope measured between two times.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "recording.h"

namespace host {

class GyroPath {
 public:
  /// Samples with a stamp that goes back or with a value that is not a number are left out.
  explicit GyroPath(const Recording& recording);

  double begin() const { return t_.empty() ? 0 : t_.front(); }
  double end() const { return t_.empty() ? 0 : t_.back(); }

  /// Mean rate from t1 to t2, s since the first IMU sample; rad/s as logged. Zero outside.
  Eigen::Vector3d mean_rate(double t1, double t2) const;

  /// R_{I1 I2}: a vector in I at t2 into I at t1, `bias` taken off first.
  Eigen::Matrix3d rotation(double t1, double t2, const Eigen::Vector3d& bias) const;

  /// The same of a gyroscope whose rates are to be read as M (rate - bias).
  Eigen::Matrix3d reordered_rotation(double t1, double t2, const Eigen::Vector3d& bias, const Eigen::Matrix3d& M) const;

  bool covers(double t1, double t2) const { return !t_.empty() && t1 >= t_.front() && t2 <= t_.back(); }

 private:
  std::size_t index_before(double t) const;
  Eigen::Vector3d rate_at(double t) const;

  std::vector<double> t_;
  std::vector<Eigen::Vector3d> w_;
  std::vector<Eigen::Vector3d> sum_;  ///< integral of the rate from the first sample on, rad
};

/// Exp of a rotation vector.
Eigen::Matrix3d rotation_of(const Eigen::Vector3d& v);

}  // namespace host
