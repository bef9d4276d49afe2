#include "spline.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace host::sim {
namespace {

constexpr int degree = 5;

}  // namespace

std::array<double, 6> uniform_basis(int wanted_degree, double u) {
  std::array<double, 6> basis{{1}};
  for (int d = 1; d <= wanted_degree; ++d) {
    // From the highest index down, so that each lower-degree weight is read before it is overwritten.
    for (int j = d; j >= 0; --j) {
      const auto i = static_cast<std::size_t>(j);
      const double from_left = j > 0 ? (u + d - j) * basis[i - 1] : 0;
      const double from_right = j < d ? (j + 1 - u) * basis[i] : 0;
      basis[i] = (from_left + from_right) / d;
    }
  }
  return basis;
}

Spline::Spline(double t0, double step, std::vector<Eigen::Vector3d> control_points)
    : t0_(t0), step_(step), control_points_(std::move(control_points)) {
  if (control_points_.size() < degree + 1 || !(step > 0))
    throw std::invalid_argument("a spline needs six control points");
}

Spline::Place Spline::locate(double t) const {
  const double s = (std::clamp(t, first_time(), last_time()) - t0_) / step_;
  // At u = 0 the weights are symmetric about the third control point, hence the shift by two.
  const double last = static_cast<double>(control_points_.size()) - (degree + 1);
  const double first = std::clamp(std::floor(s) - 2, 0.0, last);
  return {static_cast<std::size_t>(first), s - 2 - first};
}

Eigen::Vector3d Spline::evaluate(double t, int order) const {
  const Place place = locate(t);
  std::array<Eigen::Vector3d, degree + 1> c;
  for (std::size_t j = 0; j <= degree; ++j) c[j] = control_points_[place.first + j];
  // The derivative of a uniform B-spline is a B-spline of one degree less on the differences of the control points.
  for (int k = 0; k < order; ++k)
    for (std::size_t j = 0; j + static_cast<std::size_t>(k) < degree; ++j) c[j] = (c[j + 1] - c[j]) / step_;
  const std::array<double, 6> basis = uniform_basis(degree - order, place.u);
  Eigen::Vector3d value = Eigen::Vector3d::Zero();
  for (std::size_t j = 0; j <= static_cast<std::size_t>(degree - order); ++j) value += basis[j] * c[j];
  return value;
}

Spline::Support Spline::support(double t) const {
  const Place place = locate(t);
  return {place.first, uniform_basis(degree, place.u)};
}

}  // namespace host::sim
