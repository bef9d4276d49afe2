// Compares an analytic Jacobian with central differences and with an independent automatic derivative.
#pragma once

#include <Eigen/Core>
#include <limits>

#include "../support/cases.h"

namespace test {

/// Step and tolerance of central differences, per scalar type. The step is relative to the typical size of a column's
/// variable. Truncation is h^2 / 6 times the third derivative: 3e-6 and 2e-13, and models have third derivatives of up
/// to a few hundred first ones (an image point near the horizon).
template <class S>
struct Differences {
  static constexpr bool single = std::is_same<S, float>::value;
  static constexpr double step = single ? 4e-3 : 1e-6;
  static constexpr double tolerance = single ? 3e-3 : 3e-9;
  /// What the two function values lose by rounding, divided by the step; `size` is the function's largest value.
  static double rounding(double size, double h) { return 16 * std::numeric_limits<S>::epsilon() * size / h; }
};

/// Tolerance against the automatic derivative (double): the
/// rounding of the analytic one alone, some dozens of operations.
template <class S>
constexpr double kAutomaticTolerance = std::is_same<S, float>::value ? 3e-5 : 1e-11;

inline void fail_column(const Id& id, int column, int row, double expected, double actual, double step,
                        double tolerance) {
  char text[256];
  std::snprintf(text, sizeof text, "row %d: expected %.9g, was %.9g (step %.3g, tolerance %.3g)", row, expected, actual,
                step, tolerance);
  fail_case(id.add("column", column), text);
}

/// `f(delta)` gives the function's value (in double) after the step delta; `typical` holds the size of each variable,
/// `inside` the largest number that the function handles where that is more than its value.
template <class S, class F>
void check_differences(const Id& id, const Eigen::MatrixXd& J, const Eigen::VectorXd& typical, F f, double inside = 0) {
  const double size = std::max(inside, f(Eigen::VectorXd::Zero(J.cols()).eval()).cwiseAbs().maxCoeff());
  for (int c = 0; c < J.cols(); ++c) {
    if (!selected(id.add("column", c).text())) continue;
    const double h = Differences<S>::step * typical(c);
    const Eigen::VectorXd step = h * Eigen::VectorXd::Unit(J.cols(), c);
    const Eigen::VectorXd numeric = (f(step) - f((-step).eval())) / (2 * h);
    const double tolerance =
        Differences<S>::tolerance * J.col(c).cwiseAbs().maxCoeff() + Differences<S>::rounding(size, h);
    for (int r = 0; r < J.rows(); ++r) {
      if (std::fabs(numeric(r) - J(r, c)) <= tolerance) continue;
      fail_column(id, c, r, numeric(r), J(r, c), h, tolerance);
    }
  }
}

/// Entry by entry, relative to the largest entry of the column; `floor` is what counts as zero.
template <class S>
void check_automatic(const Id& id, const Eigen::MatrixXd& J, const Eigen::MatrixXd& automatic, double floor) {
  for (int c = 0; c < J.cols(); ++c) {
    if (!selected(id.add("column", c).text())) continue;
    const double tolerance = kAutomaticTolerance<S> * std::max(automatic.col(c).cwiseAbs().maxCoeff(), floor);
    for (int r = 0; r < J.rows(); ++r) {
      if (std::fabs(automatic(r, c) - J(r, c)) <= tolerance) continue;
      fail_column(id, c, r, automatic(r, c), J(r, c), 0, tolerance);
    }
  }
}

}  // namespace test
