// The reference's problem: what is measured, what is unknown, and what is known beforehand. Written apart from the
// core: neither its code nor its layouts are used here.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "calibration_file.h"
#include "recording.h"
#include "replay/core.h"

namespace host::reference {

struct State {
  std::int64_t t_ns = 0;
  Eigen::Quaterniond q_GI{1, 0, 0, 0};
  Eigen::Vector3d p_GI{0, 0, 0}, v_GI{0, 0, 0}, b_a{0, 0, 0}, b_g{0, 0, 0};
};

/// The IMU between two states: all samples of the stretch, which may reach further on both sides.
struct Link {
  int from = 0, to = 0;
  int samples = 0;  ///< index in Problem::samples
};

/// Only the biases go on from one state to the other.
struct BiasWalk {
  int from = 0, to = 0;
  double gap_s = 0;
};

/// At anchor + direction / inverse_distance; the direction has unit length, the anchor is fixed.
struct Landmark {
  Eigen::Vector3d anchor{0, 0, 0}, direction{0, 0, 1};
  double inverse_distance = 0;  ///< 1/m
  double prior_sigma = 5;       ///< 1/m, of the weak prior about zero on the inverse distance from the first camera
  bool tie = false;             ///< of several segments: the prior counts from the anchor
};

struct Point {
  int state = 0, landmark = 0, camera = 0;
  Eigen::Vector2d uv{0, 0};  ///< px
  bool rejected = false;
  int segment = 0;              ///< a track's drift begins at its first point in each
  Eigen::Vector2d drift{0, 0};  ///< px, estimate of the random walk there
};

struct Problem {
  CoreModel model;
  Calibration prior_mean;
  std::vector<double> prior_sigma;  ///< per parameter, in the order of parameter_names()
  double scatter = 1;               ///< variance for the sigmas, from how far segments disagree: told, not found here
  Calibration theta;                ///< the estimate
  std::vector<State> states;
  std::vector<std::vector<ImuSample>> samples;
  std::vector<Link> links;
  std::vector<BiasWalk> walks;
  std::vector<Landmark> landmarks;
  std::vector<Point> points;
  std::vector<int> gauges;          ///< states whose position and rotation about gravity are held
  std::vector<int> chain_starts;    ///< states with a prior on their biases
  std::vector<int> segment_starts;  ///< states with a prior on their velocity
};

/// Places the landmarks of a problem anew, from its states, points and theta. Points of a landmark that cannot be
/// placed are marked as rejected; it stays where it is.
void triangulate(Problem* problem);

/// Pixels to a direction in the camera, of any length; false where the lens does not reach.
bool unproject(const CameraCalibration& camera, const Eigen::Vector2d& uv, Eigen::Vector3d* h);

}  // namespace host::reference
