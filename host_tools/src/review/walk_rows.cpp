#include "review/walk_rows.h"

#include <cmath>
#include <map>

namespace host::review {
namespace {

using Eigen::VectorXd;

constexpr int kState = reference::kPoseSize + reference::kMotionSize, kFirstBias = reference::kPoseSize + 3;
/// Of a step's information, what must be left beside the states that follow it: less is the rounding of doubles (the
/// last keyframe's bias is in no residual but its own walk).
constexpr double kRounding = 1e-8;

}  // namespace

WalkRows::WalkRows(const reference::Problem& problem) {
  reference::CeresProblem ceres(problem);
  linearise(&ceres);
  n_theta_ = static_cast<int>(problem.prior_sigma.size());
  const int first_state = static_cast<int>(J_.cols()) - n_theta_ - kState * static_cast<int>(problem.states.size());
  for (const reference::Link& l : problem.links) to_bias_.push_back(first_state + kState * l.to + kFirstBias);
  for (const reference::BiasWalk& w : problem.walks) to_bias_.push_back(first_state + kState * w.to + kFirstBias);
  factor_.compute(Eigen::SparseMatrix<double>(J_.transpose() * J_));
  if (!solved()) return;
  residual_ -= J_ * factor_.solve(J_.transpose() * residual_);
}

void WalkRows::linearise(reference::CeresProblem* ceres) {
  ceres::Problem::EvaluateOptions options;
  options.parameter_blocks = ceres->blocks();
  ceres->ceres().GetResidualBlocks(&options.residual_blocks);
  std::map<ceres::ResidualBlockId, int> row_of;
  int row = 0;
  for (const ceres::ResidualBlockId id : options.residual_blocks) {
    row_of[id] = row;
    row += ceres->ceres().GetCostFunctionForResidualBlock(id)->num_residuals();
  }
  for (const ceres::ResidualBlockId id : ceres->motion_residuals()) {
    first_row_.push_back(row_of.at(id));
    rows_.push_back(ceres->ceres().GetCostFunctionForResidualBlock(id)->num_residuals());
  }
  std::vector<double> residuals;
  ceres::CRSMatrix crs;
  ceres->ceres().Evaluate(options, nullptr, &residuals, nullptr, &crs);
  residual_ = Eigen::Map<VectorXd>(residuals.data(), static_cast<Eigen::Index>(residuals.size()));
  J_ = Eigen::Map<const Rows>(crs.num_rows, crs.num_cols, static_cast<Eigen::Index>(crs.values.size()), crs.rows.data(),
                              crs.cols.data(), crs.values.data());
}

/// A step enters the residuals as the bias that it leads to does, in this link alone.
WalkRows::Column WalkRows::step_column(std::size_t link, int axis) const {
  Column out(J_.rows());
  for (int row = first_row_[link]; row < first_row_[link] + rows_[link]; ++row) {
    const double c = J_.coeff(row, to_bias_[link] + axis);
    if (c != 0) out.insert(row) = c;
  }
  return out;
}

StepTest WalkRows::test(std::size_t link, int axis) const {
  const Column c = step_column(link, axis);
  const VectorXd half = factor_.matrixL().solve(VectorXd(J_.transpose() * c));
  const double own = c.squaredNorm(), left = own - half.squaredNorm();
  if (!(left > kRounding * own)) return {};
  return {c.dot(residual_) / left, 1 / std::sqrt(left)};
}

VectorXd WalkRows::moves(std::size_t link, int axis, double size) const {
  const VectorXd pull = J_.transpose() * step_column(link, axis);
  return factor_.solve(pull).tail(n_theta_) * size;
}

}  // namespace host::review
