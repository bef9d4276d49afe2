// Square-root rows of sets of segments over [theta | terms | rhs], and their sums.
//
// A set's rows are an upper triangle R with the residual norm in its corner: for any theta and terms the set's cost,
// with all states and landmarks at their best, is |R (x, -1)|^2. Sums of sets are folds. Everything is linear here: the
// columns are corrections of theta from where the core linearised, and the terms' values themselves (the right-hand
// side is moved so that zero means "no effect" also for terms that the core held at another value).
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "diagnosis/score_test.h"

namespace host::diagnosis {

using SEGCAL_NS::TermGroup;

struct Rows {
  Eigen::MatrixXd R;  ///< upper triangle, columns [theta | terms | rhs]
  double dof = 0;     ///< residuals minus states and landmarks; theta and terms are not counted

  int columns() const { return static_cast<int>(R.cols()) - 1; }
  bool empty() const { return R.size() == 0; }
};

/// Triangle of rows of any number.
Eigen::MatrixXd triangle_of(const Eigen::MatrixXd& rows);

/// R^-1 of an upper triangle; rows and columns with a pivot of next to nothing are zero.
Eigen::MatrixXd inverse_of_triangle(const Eigen::MatrixXd& R);

/// The sum of sets over the same columns.
Rows sum_of(const std::vector<const Rows*>& sets);

/// The same rows with the right-hand side for columns that count from elsewhere: where the rows were linearised they
/// are `at`, one entry per column.
void count_from(const Eigen::VectorXd& at, Rows* rows);

/// A Gaussian on theta's corrections.
struct Prior {
  Eigen::VectorXd mean, sigma;
};
/// Rows with the prior of theta folded in. It is no measurement: dof stays.
Rows with_prior(const Rows& rows, const Prior& prior);

/// Only theta, the columns of these groups in this order, and the rhs; other terms are zero.
Rows with_groups(const Rows& rows, int n_theta, const std::vector<TermGroup>& groups);

/// |R (x, -1)|^2.
double cost_at(const Rows& rows, const Eigen::VectorXd& x);

/// Its minimum, and what the triangle has below: R x = d.
struct Solution {
  Eigen::VectorXd x;
  Eigen::MatrixXd covariance;
  double cost = 0;
};
/// Columns without a direction of their own stay zero.
Solution solve(const Rows& rows);

/// What the set says about the last `m` columns when those before are free: R_mm x = d_m.
struct Marginal {
  Eigen::MatrixXd R;
  Eigen::VectorXd d;
};
Marginal marginal_of(const Rows& rows, int m);

}  // namespace host::diagnosis
