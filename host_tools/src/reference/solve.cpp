#include "reference/solve.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cstdio>

#include "reference/ceres_problem.h"
#include "replay/words.h"

namespace host::reference {
namespace {

/// Theta as a list of numbers that can be subtracted: rotations relative to another calibration's.
Eigen::VectorXd theta_step(const Calibration& from, const Calibration& to) {
  std::vector<double> out;
  const auto put = [&out](const auto& v, int n) {
    for (int i = 0; i < n; ++i) out.push_back(v(i));
  };
  const auto turn = [](const Eigen::Matrix3d& a, const Eigen::Matrix3d& b) {
    return rotation_vector<double>(Eigen::Quaterniond(Eigen::Matrix3d(b * a.transpose())));
  };
  for (std::size_t c = 0; c < from.cameras.size(); ++c) {
    const CameraCalibration &a = from.cameras[c], &b = to.cameras[c];
    put(turn(a.R_CI, b.R_CI), 3);
    put(Eigen::Vector3d(b.p_CI - a.p_CI), 3);
    put(Eigen::Vector4d(b.intrinsics - a.intrinsics), 4);
    put(Eigen::Vector4d(b.distortion - a.distortion), camera_parameters(a) - 10);
  }
  double a[kImuSize], b[kImuSize];
  imu_block(from.imu, a);
  imu_block(to.imu, b);
  for (int i = 0; i < 12; ++i) out.push_back(b[i] - a[i]);
  put(turn(from.imu.R_AI, to.imu.R_AI), 3);
  return Eigen::Map<Eigen::VectorXd>(out.data(), static_cast<Eigen::Index>(out.size()));
}

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

/// Parameter values as printed, in the order of parameter_names(): rotations as rotation vectors.
Eigen::VectorXd printed_values(const Calibration& c) {
  Calibration zero = c;
  for (CameraCalibration& camera : zero.cameras) {
    camera.R_CI.setIdentity();
    camera.p_CI.setZero();
    camera.intrinsics.setZero();
    camera.distortion.setZero();
  }
  zero.imu.T_g.setZero();
  zero.imu.T_a.setZero();
  zero.imu.R_AI.setIdentity();
  return theta_step(zero, c);
}

/// How the printed numbers of a rotation move with a small turn Exp(d) R.
Eigen::Matrix3d rotation_vector_by_turn(const Eigen::Matrix3d& R) {
  using Jet = ceres::Jet<double, 3>;
  const Jet d[3] = {Jet(0, 0), Jet(0, 1), Jet(0, 2)};
  const Vector3<Jet> r = rotation_vector<Jet>(turned_by(d) * Eigen::Quaterniond(R).cast<Jet>());
  Eigen::Matrix3d J;
  for (int i = 0; i < 3; ++i) J.row(i) = r(i).v.transpose();
  return J;
}

Eigen::VectorXd printed_sigmas(const Calibration& theta, const Eigen::MatrixXd& covariance) {
  Eigen::VectorXd out = covariance.diagonal().cwiseSqrt();
  const auto rotation = [&](Eigen::Index first, const Eigen::Matrix3d& R) {
    const Eigen::Matrix3d J = rotation_vector_by_turn(R);
    out.segment<3>(first) = (J * covariance.block<3, 3>(first, first) * J.transpose()).diagonal().cwiseSqrt();
  };
  Eigen::Index first = 0;
  for (const CameraCalibration& c : theta.cameras) {
    rotation(first, c.R_CI);
    first += camera_parameters(c);
  }
  rotation(out.size() - 3, theta.imu.R_AI);
  return out;
}

/// Directions whose sigma stays above half the prior's, blindest first.
std::vector<CoreDirection> blind_directions(const Eigen::MatrixXd& covariance, const Eigen::VectorXd& prior_sigma) {
  const Eigen::VectorXd inverse = prior_sigma.cwiseInverse();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(inverse.asDiagonal() * covariance * inverse.asDiagonal());
  std::vector<CoreDirection> out;
  for (Eigen::Index i = prior_sigma.size() - 1; i >= 0; --i) {
    const double sigma = std::sqrt(eigen.eigenvalues()(i));
    if (sigma < 0.5) break;
    Eigen::Index largest;
    eigen.eigenvectors().col(i).cwiseAbs().maxCoeff(&largest);
    const Eigen::VectorXd v = eigen.eigenvectors().col(i) / eigen.eigenvectors()(largest, i);
    out.push_back({std::vector<double>(v.data(), v.data() + v.size()), sigma});
  }
  return out;
}

std::string unit_of(const std::string& name) {
  const std::string last = name.substr(name.rfind('.') + 1);
  if (name.find(".r_") != std::string::npos) return "rad";
  if (name.find(".p_") != std::string::npos) return "m";
  return last == "fx" || last == "fy" || last == "cx" || last == "cy" ? "px" : "-";
}

/// Moves on with the fixed parameters held at the prior's mean.
void hold_fixed(Problem* problem, const std::vector<CoreParameter>& parameters, const SolveOptions& options) {
  const std::vector<double> sigma = problem->prior_sigma;
  bool any = false;
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    if (parameters[i].verdict != "fixed") continue;
    any = true;
    problem->prior_sigma[i] *= 1e-4;
  }
  if (any) solve(problem, options);
  problem->prior_sigma = sigma;
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
    for (Eigen::Index i = 0; i < step.size(); ++i) moved = std::max(moved, std::abs(step(i)) / problem->prior_sigma[static_cast<std::size_t>(i)]);
    fit.converged = moved < 1e-5 && summary.IsSolutionUsable();
    if (options.progress) {
      char line[160];
      std::snprintf(line, sizeof line, "round %d: cost %.3f, %zu iterations, theta moved by %.1e of its prior's sigmas, %.1f s",
                    round + 1, fit.cost, summary.iterations.size(), moved, summary.total_time_in_seconds);
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
  if (!covariance.Compute(blocks, &ceres.ceres())) throw InputError("Ceres finds no covariance: the problem has no full rank");
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

CoreResult judged(Problem* problem, const Fit& fit, const SolveOptions& options) {
  static constexpr double kObserved = 0.3, kWeak = 0.5, kLeastRatio = 0.02, kMostRatio = 6;  // as in lib/src/api/release.h
  CoreResult out;
  const double ratio = fit.dof > 0 ? fit.chi2 / fit.dof : 0;
  out.noise_scale = std::sqrt(std::max({1.0, ratio, problem->scatter}));
  const Eigen::VectorXd prior = Eigen::Map<const Eigen::VectorXd>(problem->prior_sigma.data(), static_cast<Eigen::Index>(problem->prior_sigma.size()));
  const Eigen::VectorXd sigma = (out.noise_scale * fit.covariance.diagonal().cwiseSqrt()).cwiseMin(prior);
  const Eigen::VectorXd printed = out.noise_scale * printed_sigmas(problem->theta, fit.covariance);
  const Eigen::VectorXd initial = printed_values(problem->prior_mean);
  const std::vector<std::string> names = parameter_names(problem->theta);
  int observed = 0;
  for (Eigen::Index i = 0; i < prior.size(); ++i) {
    CoreParameter p;
    p.name = names[static_cast<std::size_t>(i)];
    p.unit = unit_of(p.name);
    const double share = sigma(i) / prior(i);
    p.verdict = share < kObserved ? "observed" : share < kWeak ? "weak" : "fixed";
    observed += share < kObserved ? 1 : 0;
    p.sigma = p.unit == "rad" ? printed(i) : sigma(i);
    p.prior_sigma = prior(i);
    p.initial = initial(i);
    out.parameters.push_back(p);
  }
  const bool plausible = ratio > kLeastRatio && ratio < kMostRatio && fit.converged;
  out.status = fit.image_points == 0 ? "insufficient" : !plausible ? "failed" : 2 * observed >= prior.size() ? "calibrated" : "insufficient";
  out.unobservable = blind_directions(fit.covariance, prior);
  hold_fixed(problem, out.parameters, options);
  const Eigen::VectorXd value = printed_values(problem->theta);
  for (Eigen::Index i = 0; i < prior.size(); ++i) out.parameters[static_cast<std::size_t>(i)].value = value(i);
  out.iterations = fit.iterations;
  out.partitions = fit.partitions;
  out.image_points = fit.image_points;
  out.converged = fit.converged;
  out.chi2 = fit.chi2;
  out.dof = fit.dof;
  std::vector<double> lengths = reprojection_lengths(*problem);
  double squares = 0;
  for (const double length : lengths) squares += length * length;
  if (!lengths.empty()) {
    out.reprojection_rms_px = std::sqrt(squares / static_cast<double>(lengths.size()));
    std::nth_element(lengths.begin(), lengths.begin() + static_cast<std::ptrdiff_t>(lengths.size() / 2), lengths.end());
    out.reprojection_median_px = lengths[lengths.size() / 2];
  }
  return out;
}

}  // namespace host::reference
