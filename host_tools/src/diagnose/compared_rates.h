// Rates of the gyroscope and of the images over the same pairs of frames.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "diagnose/gyro_path.h"
#include "diagnose/image_rotation.h"

namespace host {

/// One of each for a pair of frames; rad/s, means taken off: a bias is no rotation.
struct ComparedRates {
  std::vector<Eigen::Vector3d> image_C, gyro_I;

  std::size_t size() const { return image_C.size(); }
  double image_rms() const;
  double gyro_rms() const;
  /// Of R gyro_I with image_C; 1: the same motion, whatever the unit. 0 where either does not turn.
  double correlation(const Eigen::Matrix3d& R) const;
};

/// `image`: of each pair. `offset`: t_imu - t_cam, s. Pairs that the gyroscope does not cover are left out.
ComparedRates rates_at(const std::vector<FramePair>& pairs, const std::vector<Eigen::Vector3d>& image,
                       const GyroPath& gyro, double offset);

}  // namespace host
