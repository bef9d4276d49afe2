#include "diagnose/gyro_path.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace host {

Eigen::Matrix3d rotation_of(const Eigen::Vector3d& v) {
  const double angle = v.norm();
  return angle > 0 ? Eigen::AngleAxisd(angle, v / angle).toRotationMatrix()
                   : Eigen::Matrix3d(Eigen::Matrix3d::Identity());
}

GyroPath::GyroPath(const Recording& recording) {
  for (const ImuSample& s : recording.imu.samples) {
    const Eigen::Vector3d w(s.gyro[0], s.gyro[1], s.gyro[2]);
    const double t = static_cast<double>(s.t_ns - recording.imu.samples.front().t_ns) * 1e-9;
    if (!w.allFinite() || (!t_.empty() && t <= t_.back())) continue;
    sum_.push_back(t_.empty() ? Eigen::Vector3d(Eigen::Vector3d::Zero())
                              : Eigen::Vector3d(sum_.back() + 0.5 * (t - t_.back()) * (w_.back() + w)));
    t_.push_back(t);
    w_.push_back(w);
  }
}

std::size_t GyroPath::index_before(double t) const {
  const auto after = std::upper_bound(t_.begin(), t_.end(), t);
  const auto index = static_cast<std::size_t>(std::max<std::ptrdiff_t>(after - t_.begin() - 1, 0));
  return std::min(index, t_.size() - 2);
}

Eigen::Vector3d GyroPath::rate_at(double t) const {
  const std::size_t k = index_before(t);
  const double share = (t - t_[k]) / (t_[k + 1] - t_[k]);
  return w_[k] + share * (w_[k + 1] - w_[k]);
}

Eigen::Vector3d GyroPath::mean_rate(double t1, double t2) const {
  if (t_.size() < 2 || !covers(t1, t2)) return Eigen::Vector3d::Zero();
  const auto integral = [this](double t) -> Eigen::Vector3d {
    const std::size_t k = index_before(t);
    return sum_[k] + 0.5 * (t - t_[k]) * (w_[k] + rate_at(t));
  };
  return (integral(t2) - integral(t1)) / (t2 - t1);
}

Eigen::Matrix3d GyroPath::rotation(double t1, double t2, const Eigen::Vector3d& bias) const {
  return reordered_rotation(t1, t2, bias, Eigen::Matrix3d::Identity());
}

/// Trapezoids from sample to sample.
Eigen::Matrix3d GyroPath::reordered_rotation(double t1, double t2, const Eigen::Vector3d& bias,
                                             const Eigen::Matrix3d& M) const {
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  if (t_.size() < 2 || !covers(t1, t2)) return R;
  double t = t1;
  Eigen::Vector3d w = rate_at(t1);
  for (std::size_t k = index_before(t1) + 1; t < t2; ++k) {
    const bool last = k >= t_.size() || t_[k] >= t2;
    const double next = last ? t2 : t_[k];
    const Eigen::Vector3d w_next = last ? rate_at(t2) : w_[k];
    R = R * rotation_of((next - t) * (M * (0.5 * (w + w_next) - bias)));
    t = next;
    w = w_next;
  }
  return R;
}

}  // namespace host
