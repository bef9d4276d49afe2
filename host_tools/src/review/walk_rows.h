// A finished calibration's residuals once more, with what each would say of a step in the biases' walk
// (docs/diagnosis.md, section 10).
#pragma once

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <vector>

#include "reference/ceres_problem.h"

namespace host::review {

/// A step of one bias between two states. The size's sigma is that of stated noise.
struct StepTest {
  double size = 0, sigma = 0;  ///< rad/s or m/s^2
  double z() const { return size / sigma; }
};

/// Linearised where the problem stands, and moved to its minimum by one step of Gauss and Newton.
class WalkRows {
 public:
  explicit WalkRows(const reference::Problem& problem);
  bool solved() const { return factor_.info() == Eigen::Success; }
  /// Sum of squares at the minimum, priors included.
  double cost() const { return residual_.squaredNorm(); }
  /// `link` counts the problem's links, then its walks over gaps; `axis`
  /// is b_a's x, y, z, then b_g's. Sigma 0: nothing shows such a step.
  StepTest test(std::size_t link, int axis) const;
  /// What theta's columns move by when that step is taken into the model.
  Eigen::VectorXd moves(std::size_t link, int axis, double size) const;

 private:
  using Rows = Eigen::SparseMatrix<double, Eigen::RowMajor>;
  using Column = Eigen::SparseVector<double>;
  void linearise(reference::CeresProblem* ceres);
  Column step_column(std::size_t link, int axis) const;

  Rows J_;
  Eigen::VectorXd residual_;
  Eigen::SimplicialLLT<Eigen::SparseMatrix<double>, Eigen::Lower, Eigen::NaturalOrdering<int>> factor_;
  /// of each link: its rows, and the column of b_a in the state that it ends at
  std::vector<int> first_row_, rows_, to_bias_;
  int n_theta_ = 0;
};

}  // namespace host::review
