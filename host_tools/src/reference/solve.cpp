#include "reference/solve.h"

#include <algorithm>
#include <cstdio>

#include "reference/ceres_problem.h"
#include "reference/theta.h"

namespace host::reference {
namespace {

ceres::Solver::Summary run_ceres(CeresProblem* problem, const SolveOptions& how) {
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::SPARSE_SCHUR;
  options.linear_solver_ordering = problem->ordering();
  options.num_threads = how.threads;
  options.max_num_iterations = how.iterations;
  options.initial_trust_region_radius = 1e8;
  options.function_tolerance = 1e-10;
  options.gradient_tolerance = 0;
  options.parameter_tolerance = 0;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem->ceres(), &summary);
  return summary;
}

/// Sum of squares with each robust residual's weight, which is what Ceres' scaled residuals are.
double weighted_squares(CeresProblem* problem, int threads) {
  ceres::Problem::EvaluateOptions options;
  options.num_threads = threads;
  std::vector<double> r;
  problem->ceres().Evaluate(options, nullptr, &r, nullptr, nullptr);
  return Eigen::Map<Eigen::VectorXd>(r.data(), static_cast<Eigen::Index>(r.size())).squaredNorm();
}

}  // namespace

Fit solve(Problem* problem, const SolveOptions& options) {
  Fit fit;
  for (int round = 0; round < options.rounds && !fit.converged; ++round) {
    const Calibration before = problem->theta;
    CeresProblem ceres(*problem);
    const ceres::Solver::Summary summary = run_ceres(&ceres, options);
    fit.iterations += static_cast<int>(summary.iterations.size());
    if (round == 0) fit.start_cost = 2 * summary.initial_cost;
    fit.cost = 2 * summary.final_cost;
    fit.image_points = ceres.image_points();
    fit.partitions = ceres.partitions();
    fit.chi2 = weighted_squares(&ceres, options.threads);
    fit.dof = ceres.degrees_of_freedom();
    ceres.take_over(problem);
    double moved = 0;  // in units of the prior's sigmas, a hundred to a thousand times the posterior's
    const Eigen::VectorXd step = theta_step(before, problem->theta);
    for (Eigen::Index i = 0; i < step.size(); ++i)
      moved = std::max(moved, std::abs(step(i)) / problem->prior_sigma[static_cast<std::size_t>(i)]);
    fit.converged = moved < 1e-5 && summary.IsSolutionUsable();
    if (options.progress) {
      char line[160];
      std::snprintf(line, sizeof line,
                    "round %d: cost %.3f, %zu iterations, theta moved by %.1e of its prior's sigmas, %.1f s", round + 1,
                    fit.cost, summary.iterations.size(), moved, summary.total_time_in_seconds);
      options.progress(line);
    }
  }
  return fit;
}

Eigen::MatrixXd theta_covariance(const Problem& problem, int threads) {
  CeresProblem ceres(problem);
  ceres::Covariance::Options options;
  options.num_threads = threads;
  options.algorithm_type = ceres::SPARSE_QR;
  ceres::Covariance covariance(options);
  const std::vector<const double*> blocks = ceres.theta_blocks();
  if (!covariance.Compute(blocks, &ceres.ceres()))
    throw InputError("Ceres finds no covariance: the problem has no full rank");
  Eigen::Index n = kImuSize;
  for (const CameraCalibration& c : problem.theta.cameras) n += camera_parameters(c);
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> out(n, n);
  covariance.GetCovarianceMatrixInTangentSpace(blocks, out.data());
  return out;
}

bool point_residual(const Problem& problem, const Point& z, Eigen::Vector2d* residual) {
  const CameraCalibration& camera = problem.theta.cameras[static_cast<std::size_t>(z.camera)];
  const State& x = problem.states[static_cast<std::size_t>(z.state)];
  const Landmark& l = problem.landmarks[static_cast<std::size_t>(z.landmark)];
  double block[kCameraSize] = {0, 0, 0, camera.p_CI.x(), camera.p_CI.y(), camera.p_CI.z()};
  std::copy_n(camera.intrinsics.data(), 4, block + 6);
  std::copy_n(camera.distortion.data(), 4, block + 10);
  const double pose[kPoseSize] = {0, 0, 0, x.p_GI.x(), x.p_GI.y(), x.p_GI.z()};
  const double landmark[kLandmarkSize] = {0, 0, l.inverse_distance};
  if (!predicted<double>(camera, x, l, pose, landmark, block, residual)) return false;
  *residual -= z.uv;
  return true;
}

void reject_outliers(Problem* problem, double limit) {
  for (Point& z : problem->points) {
    Eigen::Vector2d r;
    z.rejected = !point_residual(*problem, z, &r) || (r - z.drift).norm() > limit * problem->model.pixel_sigma;
  }
}

std::vector<double> reprojection_lengths(const Problem& problem) {
  std::vector<double> out;
  Eigen::Vector2d r;
  for (const Point& z : problem.points) {
    if (!z.rejected && point_residual(problem, z, &r)) out.push_back(r.norm());
  }
  return out;
}

}  // namespace host::reference
