// A uniform B-spline of order 6 (quintic pieces, four continuous derivatives) through 3-D control points.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

namespace host::sim {

/// Weights of the control points i .. i + degree on the local parameter u in [0, 1). Entries above `degree` are zero.
std::array<double, 6> uniform_basis(int degree, double u);

/// Control point k belongs to time t0 + k * step. A signal sampled slowly against its own changes passes as it is; what
/// is faster than half the sampling rate is smoothed away. Constants and straight lines are reproduced exactly.
class Spline {
 public:
  Spline() = default;
  /// `t0` and `step` in s; at least six control points.
  Spline(double t0, double step, std::vector<Eigen::Vector3d> control_points);

  /// First and last time that may be evaluated, s.
  double first_time() const { return t0_ + 2 * step_; }
  double last_time() const { return t0_ + step_ * (static_cast<double>(control_points_.size()) - 4); }

  /// Value, first and second derivative (order 0, 1, 2) at time t, s; times outside are clamped to the span.
  Eigen::Vector3d evaluate(double t, int order) const;

  /// The six control points that act at time t, and their weights: what a fit needs.
  struct Support {
    std::size_t first = 0;
    std::array<double, 6> weights{};
  };
  Support support(double t) const;

  const std::vector<Eigen::Vector3d>& control_points() const { return control_points_; }

 private:
  struct Place {
    std::size_t first;  ///< first of the six control points
    double u;           ///< position inside the interval, 0 to 1
  };
  Place locate(double t) const;

  double t0_ = 0, step_ = 1;
  std::vector<Eigen::Vector3d> control_points_;
};

}  // namespace host::sim
