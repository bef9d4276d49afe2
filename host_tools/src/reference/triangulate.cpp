// First places of landmarks: the ray of the first image point,
// and the inverse distance that fits the other points best.
#include <algorithm>
#include <cmath>

#include "reference/imu_residual.h"
#include "reference/solve.h"

namespace host::reference {
namespace {

/// Robust cost of a landmark's points.
double cost_of(const Problem& problem, const std::vector<const Point*>& points) {
  double sum = 0;
  for (const Point* z : points) {
    Eigen::Vector2d r;
    const double e = point_residual(problem, *z, &r) ? r.norm() / problem.model.pixel_sigma : 1e3;
    sum += e < problem.model.huber ? e * e : problem.model.huber * (2 * e - problem.model.huber);
  }
  return sum;
}

bool place(Problem* problem, std::size_t index, const std::vector<const Point*>& points) {
  const Point& first = *points.front();
  const CameraCalibration& camera = problem->theta.cameras[static_cast<std::size_t>(first.camera)];
  const State& x = problem->states[static_cast<std::size_t>(first.state)];
  Eigen::Vector3d h;
  if (!unproject(camera, first.uv, &h)) return false;
  Landmark& l = problem->landmarks[index];
  l.direction = (x.q_GI * (camera.R_CI.transpose() * h)).normalized();
  l.anchor = x.p_GI - x.q_GI * (camera.R_CI.transpose() * camera.p_CI);
  // The cost has its minimum at one inverse distance or another: look at a grid, then between its neighbours.
  static constexpr double kGrid[] = {0,    0.01, 0.02, 0.04, 0.07, 0.1, 0.14, 0.2, 0.27,
                                     0.35, 0.45, 0.6,  0.8,  1.1,  1.5, 2,    3,   5};
  double best = 0, least = INFINITY, step = 0.01;
  for (std::size_t i = 0; i < std::size(kGrid); ++i) {
    l.inverse_distance = kGrid[i];
    const double cost = cost_of(*problem, points);
    if (cost >= least) continue;
    least = cost;
    best = kGrid[i];
    step = i + 1 < std::size(kGrid) ? kGrid[i + 1] - kGrid[i] : 2;
  }
  for (int i = 0; i < 12; ++i, step *= 0.5) {
    for (const double at : {best - 0.5 * step, best + 0.5 * step}) {
      l.inverse_distance = at;
      const double cost = cost_of(*problem, points);
      if (cost >= least) continue;
      least = cost;
      best = at;
    }
  }
  l.inverse_distance = best;
  return least < 1e3 * static_cast<double>(points.size());
}

/// Newton on the angle from the axis, from that of a lens without coefficients.
bool unproject_wide(const CameraCalibration& camera, const Eigen::Vector2d& target, Eigen::Vector3d* h) {
  using Jet = ceres::Jet<double, 1>;
  Jet k[4];
  for (int i = 0; i < 4; ++i) k[i] = Jet(camera.distortion(i));
  double angle = target.norm();
  for (int i = 0; i < 50; ++i) {
    const Jet a(angle, 0);
    const double radius = target.norm();
    const Jet reached = equidistant<Jet>(k, Vector3<Jet>(sin(a), Jet(0), cos(a))).x();
    const double step = (radius - reached.a) / reached.v[0];
    if (!std::isfinite(step)) return false;
    angle += std::clamp(step, -0.2, 0.2);
    if (std::abs(step) > 1e-12) continue;
    h->head<2>() = target * (std::sin(angle) / radius);
    h->z() = std::cos(angle);
    return angle > 0 && h->z() > -0.17364818;
  }
  return false;
}

}  // namespace

bool unproject(const CameraCalibration& camera, const Eigen::Vector2d& uv, Eigen::Vector3d* h) {
  const Eigen::Vector2d target((uv.x() - camera.intrinsics(2)) / camera.intrinsics(0),
                               (uv.y() - camera.intrinsics(3)) / camera.intrinsics(1));
  if (camera.model == DistortionModel::equidistant && target.norm() > 1) return unproject_wide(camera, target, h);
  using Jet = ceres::Jet<double, 2>;
  Jet k[4];
  for (int i = 0; i < 4; ++i) k[i] = Jet(camera.distortion(i));
  Eigen::Vector2d xy = target;
  for (int i = 0; i < 50; ++i) {
    const Vector2<Jet> d = distorted<Jet>(camera.model, k, Vector2<Jet>(Jet(xy.x(), 0), Jet(xy.y(), 1)));
    Eigen::Matrix2d J;
    J << d.x().v.transpose(), d.y().v.transpose();
    const Eigen::Vector2d step = J.inverse() * (target - Eigen::Vector2d(d.x().a, d.y().a));
    const double length = step.norm();
    if (!std::isfinite(length)) return false;
    xy += length > 0.3 ? Eigen::Vector2d(step * (0.3 / length)) : step;
    *h = xy.homogeneous();
    if (length < 1e-12) return true;
  }
  return false;
}

void triangulate(Problem* problem) {
  std::vector<std::vector<const Point*>> points(problem->landmarks.size());
  for (const Point& z : problem->points) {
    if (!z.rejected) points[static_cast<std::size_t>(z.landmark)].push_back(&z);
  }
  std::vector<bool> placed(problem->landmarks.size(), false);
  for (std::size_t l = 0; l < points.size(); ++l) placed[l] = points[l].size() >= 2 && place(problem, l, points[l]);
  for (Point& z : problem->points) z.rejected = z.rejected || !placed[static_cast<std::size_t>(z.landmark)];
}

}  // namespace host::reference
