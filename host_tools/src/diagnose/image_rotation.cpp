#include "diagnose/image_rotation.h"

#include <Eigen/Dense>
#include <cmath>
#include <unordered_map>

#include "camera_geometry.h"
#include "clock/criteria.h"

namespace host {
namespace {

using namespace SEGCAL_NS::clock_criteria;

struct Seen {
  Eigen::Vector3d ray;
  double line;
};

using Rays = std::unordered_map<std::uint32_t, Seen>;

double line_of(const CameraCalibration& camera, const TrackPoint& point) {
  return camera.reads_columns ? point.u - 0.5 * camera.width : point.v - 0.5 * camera.height;
}

Rays rays_of(const Frame& frame, const CameraCalibration& camera) {
  Rays out;
  for (const TrackPoint& point : frame.points) {
    if (!std::isfinite(point.u) || !std::isfinite(point.v)) continue;
    if (const auto x = undistort(camera, {point.u, point.v}))
      out[point.track_id] = {Eigen::Vector3d(x->x(), x->y(), 1).normalized(), line_of(camera, point)};
  }
  return out;
}

/// Rotation that turns the second set into the first, weighted.
Eigen::Matrix3d wahba(const FramePair& pair, const std::vector<double>& weights) {
  Eigen::Matrix3d B = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < weights.size(); ++i) B += weights[i] * pair.rays1[i] * pair.rays2[i].transpose();
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(B, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector3d signs(1, 1, (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1);
  return svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
}

}  // namespace

std::vector<FramePair> frame_pairs(const Recording& recording, const CameraCalibration& camera) {
  std::vector<FramePair> out;
  if (recording.cameras.empty() || recording.imu.samples.empty()) return out;
  const std::int64_t zero_ns = recording.imu.samples.front().t_ns;
  Rays before;
  std::int64_t before_ns = 0;
  for (const Frame& frame : recording.cameras[0].frames) {
    const double dt = static_cast<double>(frame.t_ns - before_ns) * 1e-9;
    if (!before.empty() && dt > 0 && dt < kShortest_s) continue;
    const Rays now = rays_of(frame, camera);
    FramePair pair;
    pair.t1 = static_cast<double>(before_ns - zero_ns) * 1e-9;
    pair.t2 = static_cast<double>(frame.t_ns - zero_ns) * 1e-9;
    for (const auto& [id, seen] : now) {
      const auto match = before.find(id);
      if (match == before.end()) continue;
      pair.rays1.push_back(match->second.ray);
      pair.lines1.push_back(match->second.line);
      pair.rays2.push_back(seen.ray);
      pair.lines2.push_back(seen.line);
    }
    if (dt >= kShortest_s && dt <= kLongest_s && pair.rays1.size() >= static_cast<std::size_t>(kLeastRays))
      out.push_back(std::move(pair));
    before = now;
    before_ns = frame.t_ns;
  }
  return out;
}

Eigen::Vector3d rate_by_rotation_alone(const FramePair& pair) {
  std::vector<double> weights(pair.rays1.size(), 1);
  Eigen::Matrix3d R = wahba(pair, weights);
  for (int round = 0; round < 4; ++round) {
    for (std::size_t i = 0; i < weights.size(); ++i) {
      const double off = (pair.rays1[i] - R * pair.rays2[i]).norm() / kTolerated;
      weights[i] = 1 / (1 + off * off);
    }
    R = wahba(pair, weights);
  }
  const Eigen::AngleAxisd turn(R);
  return turn.angle() * turn.axis() / (pair.t2 - pair.t1);
}

double misfit(const FramePair& pair, const Eigen::Matrix3d& R_12) {
  Eigen::Matrix3d M = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < pair.rays1.size(); ++i) {
    const Eigen::Vector3d n = pair.rays1[i].cross(R_12 * pair.rays2[i]);
    M.noalias() += n * n.transpose();
  }
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>().computeDirect(M, Eigen::EigenvaluesOnly).eigenvalues()[0];
}

}  // namespace host
