#include "compare/trajectory_error.h"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <limits>

namespace host {
namespace {

constexpr double pair_tolerance = 0.1;  // of the length of a piece of path
constexpr double coarse_step_s = 0.01;  // the position changes little within: one metre per second gives a centimetre
constexpr double fine_step_s = 1e-6;

/// Poses of the estimate and of the reference at the same times.
struct Pairs {
  Poses estimate, reference;
};

Pairs paired(const Poses& estimate, const Poses& reference, double shift_s, double largest_gap_s) {
  const std::int64_t shift_ns = std::llround(shift_s * 1e9);
  Pairs out;
  for (const Pose& pose : estimate) {
    Pose at;
    if (!pose_at(reference, pose.t_ns + shift_ns, largest_gap_s, &at)) continue;
    out.estimate.push_back(pose);
    out.reference.push_back(at);
  }
  return out;
}

Eigen::Vector3d centre_of(const Poses& poses) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Pose& pose : poses) sum += pose.p_GI;
  return sum / static_cast<double>(std::max<std::size_t>(poses.size(), 1));
}

/// sum (onto - centre) (from - centre)'.
Eigen::Matrix3d cross_covariance(const Poses& from, const Poses& onto, const Eigen::Vector3d& c_from,
                                 const Eigen::Vector3d& c_onto) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < from.size(); ++i) sum += (onto[i].p_GI - c_onto) * (from[i].p_GI - c_from).transpose();
  return sum;
}

void move(Poses& poses, const Motion& motion) {
  const Eigen::Quaterniond q(motion.R);
  for (Pose& pose : poses) {
    pose.p_GI = motion.R * pose.p_GI + motion.t;
    pose.q_GI = (q * pose.q_GI).normalized();
  }
}

double aligned_rmse(const Poses& estimate, const Poses& reference, double shift_s, const ErrorOptions& options) {
  const Pairs pairs = paired(estimate, reference, shift_s, options.largest_gap_s);
  // A shift that leaves little overlap must not win by having little to explain.
  if (2 * pairs.estimate.size() < estimate.size() || pairs.estimate.size() < 3)
    return std::numeric_limits<double>::infinity();
  const Motion m = align(pairs.estimate, pairs.reference, options.alignment);
  double sum = 0;
  for (std::size_t i = 0; i < pairs.estimate.size(); ++i) {
    sum += (m.R * pairs.estimate[i].p_GI + m.t - pairs.reference[i].p_GI).squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(pairs.estimate.size()));
}

/// A grid over the allowed range, then golden sections around its best point.
double estimated_shift(const Poses& estimate, const Poses& reference, const ErrorOptions& options) {
  const auto cost = [&](double shift) { return aligned_rmse(estimate, reference, shift, options); };
  const int steps = static_cast<int>(std::ceil(options.largest_shift_s / coarse_step_s));
  double best = 0, best_cost = cost(0);
  for (int k = -steps; k <= steps; ++k) {
    const double shift = k * coarse_step_s, c = cost(shift);
    if (c < best_cost) {
      best = shift;
      best_cost = c;
    }
  }
  constexpr double golden = 0.6180339887498949;
  double low = best - coarse_step_s, high = best + coarse_step_s;
  double a = high - golden * (high - low), b = low + golden * (high - low), cost_a = cost(a), cost_b = cost(b);
  while (high - low > fine_step_s) {
    if (cost_a < cost_b) {
      high = b;
      b = a;
      cost_b = cost_a;
      cost_a = cost(a = high - golden * (high - low));
    } else {
      low = a;
      a = b;
      cost_a = cost_b;
      cost_b = cost(b = low + golden * (high - low));
    }
  }
  return 0.5 * (low + high);
}

double angle_of(const Eigen::Quaterniond& q) { return 2 * std::atan2(q.vec().norm(), std::abs(q.w())); }

std::vector<double> distances_along(const Poses& poses) {
  std::vector<double> out(poses.size(), 0);
  for (std::size_t i = 1; i < poses.size(); ++i) out[i] = out[i - 1] + (poses[i].p_GI - poses[i - 1].p_GI).norm();
  return out;
}

/// The index after `i` whose distance from there is nearest to `length`; the last one if all are nearer.
std::size_t nearest_after(const std::vector<double>& along, std::size_t i, double length) {
  const auto begin = along.begin() + static_cast<std::ptrdiff_t>(i) + 1;
  auto it = std::lower_bound(begin, along.end(), along[i] + length);
  if (it == along.end()) --it;
  if (it != begin && along[i] + length - *(it - 1) <= *it - (along[i] + length)) --it;
  while (it != begin && *(it - 1) == *it) --it;  // at rest the distance stays: the first of them
  return static_cast<std::size_t>(it - along.begin());
}

RelativeError relative_error(const Pairs& pairs, double length) {
  const std::vector<double> along = distances_along(pairs.reference);
  std::vector<double> position, attitude;
  for (std::size_t i = 0; i + 1 < along.size(); ++i) {
    const std::size_t j = nearest_after(along, i, length);
    if (std::abs(along[j] - along[i] - length) > pair_tolerance * length) continue;
    const Pose &e0 = pairs.estimate[i], &e1 = pairs.estimate[j], &r0 = pairs.reference[i], &r1 = pairs.reference[j];
    const Eigen::Quaterniond turn_e = e0.q_GI.conjugate() * e1.q_GI, turn_r = r0.q_GI.conjugate() * r1.q_GI;
    const Eigen::Vector3d step_e = e0.q_GI.conjugate() * (e1.p_GI - e0.p_GI),
                          step_r = r0.q_GI.conjugate() * (r1.p_GI - r0.p_GI);
    position.push_back((step_e - step_r).norm());
    attitude.push_back(angle_of(turn_r.conjugate() * turn_e));
  }
  return {length, spread_of(position), spread_of(attitude)};
}

}  // namespace

Alignment alignment_from_name(const std::string& name) {
  if (name == "none") return Alignment::none;
  if (name == "yaw") return Alignment::yaw;
  if (name == "se3") return Alignment::se3;
  throw InputError("--align: expected none, yaw or se3, found '" + name + "'");
}

Spread spread_of(std::vector<double> errors) {
  Spread out;
  out.n = errors.size();
  if (errors.empty()) return out;
  double sum = 0;
  for (double e : errors) sum += e * e;
  out.rmse = std::sqrt(sum / static_cast<double>(errors.size()));
  std::sort(errors.begin(), errors.end());
  const std::size_t half = errors.size() / 2;
  out.median = errors.size() % 2 ? errors[half] : 0.5 * (errors[half - 1] + errors[half]);
  out.max = errors.back();
  return out;
}

Motion align(const Poses& from, const Poses& onto, Alignment alignment) {
  Motion motion;
  if (alignment == Alignment::none) return motion;
  const Eigen::Vector3d c_from = centre_of(from), c_onto = centre_of(onto);
  const Eigen::Matrix3d C = cross_covariance(from, onto, c_from, c_onto);
  if (alignment == Alignment::yaw) {
    motion.R = Eigen::AngleAxisd(std::atan2(C(1, 0) - C(0, 1), C(0, 0) + C(1, 1)), Eigen::Vector3d::UnitZ())
                   .toRotationMatrix();
  } else {
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(C, Eigen::ComputeFullU | Eigen::ComputeFullV);  // Umeyama 1991
    Eigen::Vector3d sign(1, 1, svd.matrixU().determinant() * svd.matrixV().determinant() < 0 ? -1 : 1);
    motion.R = svd.matrixU() * sign.asDiagonal() * svd.matrixV().transpose();
  }
  motion.t = c_onto - motion.R * c_from;
  return motion;
}

std::optional<TrajectoryError> trajectory_error(const Poses& estimate, const Poses& reference,
                                                const ErrorOptions& options) {
  TrajectoryError out;
  if (options.largest_shift_s > 0) out.time_shift_s = estimated_shift(estimate, reference, options);
  Pairs pairs = paired(estimate, reference, out.time_shift_s, options.largest_gap_s);
  if (pairs.estimate.size() < 3) return std::nullopt;
  move(pairs.estimate, align(pairs.estimate, pairs.reference, options.alignment));
  std::vector<double> position, attitude;
  for (std::size_t i = 0; i < pairs.estimate.size(); ++i) {
    position.push_back((pairs.estimate[i].p_GI - pairs.reference[i].p_GI).norm());
    attitude.push_back(angle_of(pairs.reference[i].q_GI.conjugate() * pairs.estimate[i].q_GI));
  }
  out.poses = pairs.estimate.size();
  out.duration_s = static_cast<double>(pairs.estimate.back().t_ns - pairs.estimate.front().t_ns) * 1e-9;
  out.path_m = distances_along(pairs.reference).back();
  out.position_m = spread_of(std::move(position));
  out.attitude_rad = spread_of(std::move(attitude));
  for (const double length : options.segment_m) out.relative.push_back(relative_error(pairs, length));
  return out;
}

}  // namespace host
