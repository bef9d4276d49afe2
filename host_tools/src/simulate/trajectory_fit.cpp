#include "trajectory_fit.h"

#include <Eigen/Geometry>
#include <Eigen/Sparse>
#include <Eigen/SparseCholesky>
#include <cmath>

#include "../csv.h"
#include "../recording.h"
#include "angles.h"

namespace host::sim {
namespace {

constexpr double longest_step = 0.1;       // s between poses, above it is a hole
constexpr double shortest_recording = 3;   // s
constexpr double roughness_weight = 1e-3;  // per pose weight of 1; decides in holes only

PoseSeries read_poses(const std::filesystem::path& file) {
  PoseSeries poses;
  CsvReader csv(file, "timestamp [ns], p_x, p_y, p_z [m], q_w, q_x, q_y, q_z (, more)", 8, 64);
  while (csv.next_row()) {
    const std::int64_t t_ns = csv.integer(0);
    if (poses.t.empty()) poses.first_ns = t_ns;
    const double t = static_cast<double>(t_ns - poses.first_ns) * 1e-9;
    if (!poses.t.empty() && t <= poses.t.back()) csv.fail("a stamp later than the one before");
    const Eigen::Quaterniond q(csv.number(4), csv.number(5), csv.number(6), csv.number(7));
    if (!(std::abs(q.norm() - 1) < 0.01)) csv.fail("a quaternion of unit length");
    poses.t.push_back(t);
    poses.p_GI.emplace_back(csv.number(1), csv.number(2), csv.number(3));
    poses.R_GI.push_back(q.normalized().toRotationMatrix());
  }
  return poses;
}

/// Quaternions without jumps of their sign.
std::vector<Eigen::Quaterniond> quaternions(const PoseSeries& poses) {
  std::vector<Eigen::Quaterniond> out;
  for (const Eigen::Matrix3d& R : poses.R_GI) {
    Eigen::Quaterniond q(R);
    if (!out.empty() && q.dot(out.back()) < 0) q.coeffs() *= -1;
    out.push_back(q);
  }
  return out;
}

void measure_fit(const PoseSeries& poses, FittedTrajectory& fit) {
  double p2 = 0, r2 = 0;
  for (std::size_t k = 0; k < poses.t.size(); ++k) {
    const BodyState state = fit.trajectory.at(poses.t[k]);
    p2 += (state.p_GI - poses.p_GI[k]).squaredNorm();
    r2 += std::pow(Eigen::AngleAxisd(Eigen::Matrix3d(state.R_GI.transpose() * poses.R_GI[k])).angle(), 2);
    if (k > 0 && poses.t[k] - poses.t[k - 1] > longest_step) fit.holes.push_back({poses.t[k - 1], poses.t[k]});
  }
  const auto n = static_cast<double>(poses.t.size());
  fit.position_rms_m = std::sqrt(p2 / n);
  fit.rotation_rms_rad = std::sqrt(r2 / n);
}

}  // namespace

Spline fit_spline(const std::vector<double>& t, const std::vector<Eigen::Vector3d>& values, double step) {
  const double t0 = -2 * step;
  const auto n = static_cast<Eigen::Index>(std::ceil(t.back() / step)) + 6;
  const Spline shape(t0, step, std::vector<Eigen::Vector3d>(static_cast<std::size_t>(n), Eigen::Vector3d::Zero()));

  std::vector<Eigen::Triplet<double>> entries;
  const auto poses = static_cast<Eigen::Index>(t.size());
  Eigen::MatrixX3d targets = Eigen::MatrixX3d::Zero(poses + n - 3, 3);
  for (Eigen::Index k = 0; k < poses; ++k) {
    const auto index = static_cast<std::size_t>(k);
    const Spline::Support support = shape.support(t[index]);
    for (std::size_t j = 0; j < 6; ++j)
      entries.emplace_back(k, static_cast<Eigen::Index>(support.first + j), support.weights[j]);
    targets.row(k) = values[index].transpose();
  }
  const double differences[] = {-1, 3, -3, 1};
  for (Eigen::Index k = 0; k + 3 < n; ++k)
    for (Eigen::Index j = 0; j < 4; ++j) entries.emplace_back(poses + k, k + j, roughness_weight * differences[j]);

  Eigen::SparseMatrix<double> A(targets.rows(), n);
  A.setFromTriplets(entries.begin(), entries.end());
  const Eigen::SparseMatrix<double> normal = A.transpose() * A;
  const Eigen::MatrixX3d right = A.transpose() * targets;
  const Eigen::MatrixX3d solution = Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>(normal).solve(right);
  std::vector<Eigen::Vector3d> control_points;
  for (Eigen::Index k = 0; k < n; ++k) control_points.push_back(solution.row(k).transpose());
  return Spline(t0, step, std::move(control_points));
}

FittedTrajectory fit_trajectory(const PoseSeries& poses, const std::string& of, double knot_step) {
  if (poses.t.empty() || poses.t.back() < shortest_recording) throw InputError(of + ": expected at least 3 s of poses");
  std::vector<Eigen::Vector3d> vector, scalar;
  for (const Eigen::Quaterniond& q : quaternions(poses)) {
    vector.push_back(q.vec());
    scalar.emplace_back(q.w(), 0, 0);
  }
  FittedTrajectory fit;
  fit.first_pose_ns = poses.first_ns;
  fit.trajectory = Trajectory(fit_spline(poses.t, poses.p_GI, knot_step), fit_spline(poses.t, vector, knot_step),
                              fit_spline(poses.t, scalar, knot_step));
  measure_fit(poses, fit);
  return fit;
}

FittedTrajectory fit_trajectory(const std::filesystem::path& file, double knot_step) {
  return fit_trajectory(read_poses(file), file.string(), knot_step);
}

}  // namespace host::sim
