// A square root of what a sensor adds to sums of squares, where those sums are left over from an elimination.
#pragma once

#include <Eigen/Eigenvalues>

namespace host {
namespace SEGCAL_NS {

/// What an elimination leaves of a column's length, below which it is rounding: 3e-5, as precise as the core's own rows
/// in float. (In double, of squares whose own size is one, 1e-16 times a few hundred states are left.)
constexpr double kLostLength = 3e-5;

/// R of `square` = R'R, the part of one sensor in `sum` = S_k, which is what the elimination has left of squares with
/// the diagonal `whole`. In what a sensor does not know `square` has no rank, and rounding makes it negative: those
/// directions are zero. A column that `sum` does not know either is nothing but rounding: its diagonal may be negative
/// beside entries that are not small in comparison, so that it is zero as a whole.
inline Eigen::MatrixXd root_of_squares(const Eigen::MatrixXd& square, const Eigen::MatrixXd& sum,
                                       const Eigen::VectorXd& whole) {
  Eigen::VectorXd length = Eigen::VectorXd::Zero(sum.cols()), scale = length;
  for (Eigen::Index c = 0; c < sum.cols(); ++c) {
    if (!(sum(c, c) > kLostLength * kLostLength * whole(c))) continue;
    length(c) = std::sqrt(sum(c, c));
    scale(c) = 1 / length(c);
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> scaled(scale.asDiagonal() * square * scale.asDiagonal());
  return scaled.eigenvalues().cwiseMax(0).cwiseSqrt().asDiagonal() * scaled.eigenvectors().transpose() *
         length.asDiagonal();
}

}  // namespace SEGCAL_NS
}  // namespace host
