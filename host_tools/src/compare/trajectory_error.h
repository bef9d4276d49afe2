// How far one trajectory is from another: alignment, time shift, errors of position and attitude, relative pose error.
#pragma once

#include <optional>
#include <string>

#include "compare/poses.h"

namespace host {

/// What is unknown between the two worlds: nothing, yaw and
/// position (gravity tells the rest: an odometry), all of SE(3).
enum class Alignment { none, yaw, se3 };
Alignment alignment_from_name(const std::string& name);  ///< none, yaw, se3. Throws InputError.

struct ErrorOptions {
  Alignment alignment = Alignment::yaw;
  double largest_gap_s = 0.25;         ///< the reference is not interpolated across more
  double largest_shift_s = 0;          ///< a time shift is estimated within +- this; 0: none
  std::vector<double> segment_m = {};  ///< lengths of path for the relative pose error
};

struct Spread {
  double rmse = 0, median = 0, max = 0;
  std::size_t n = 0;
};
Spread spread_of(std::vector<double> errors);

struct RelativeError {
  double segment_m = 0;
  Spread position_m, attitude_rad;
};

struct TrajectoryError {
  std::size_t poses = 0;              ///< of the estimate with a reference
  double duration_s = 0, path_m = 0;  ///< of the reference over these
  double time_shift_s = 0;            ///< t_reference = t_estimate + shift
  Spread position_m, attitude_rad;    ///< at each pose, after alignment
  std::vector<RelativeError> relative;
};

/// The rigid motion that brings `from` onto `onto` in least squares of positions: p_onto = R p_from + t.
struct Motion {
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  Eigen::Vector3d t = Eigen::Vector3d::Zero();
};
Motion align(const Poses& from, const Poses& onto, Alignment alignment);

/// Errors of `estimate` against `reference`, which is interpolated at the estimate's stamps. Empty where fewer than
/// three poses have a reference.
///
/// Position and attitude errors are those of the pose difference at each time after alignment: the paper's evaluation
/// (Sec. VI-C1). The relative pose error compares the motion over pieces of path: for each pose the one whose distance
/// along the reference is nearest to `segment_m` and within 10 % of it, as evo's RPE with all pairs does.
std::optional<TrajectoryError> trajectory_error(const Poses& estimate, const Poses& reference,
                                                const ErrorOptions& options);

}  // namespace host
