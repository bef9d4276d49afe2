#include "replay/track_noise.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <array>
#include <cmath>

#include "camera_geometry.h"
#include "replay/track_residuals.h"
#include "replay/whitening.h"

namespace host {
namespace {

/// Below this no tracker is, and a fit has no way to tell it from none.
constexpr double kLeastWhite_px = 0.05, kLeastWalk = 0.01;

/// One corner in one camera and segment.
struct Track {
  std::vector<double> t_s;
  Eigen::Matrix<double, Eigen::Dynamic, 2, Eigen::RowMajor> r;  ///< px, a point in each row
  Eigen::Matrix<double, Eigen::Dynamic, 6, Eigen::RowMajor> J;  ///< of r by the landmark: x by all three, y by them
  double depth_information = 0;                                 ///< m^2, prior on the inverse distance
};

struct Weights {
  Eigen::VectorXd point, step;  ///< 1: as stated; less: off
};

/// The landmark in the camera, times its inverse distance, with that and its direction moved by d.
Eigen::Vector3d in_camera(const CameraCalibration& camera, const CoreState& x, const CoreLandmark& l,
                          const Eigen::Vector3d& d) {
  const Eigen::Vector3d e1 = l.direction.unitOrthogonal(), e2 = l.direction.cross(e1);
  const double rho = l.inverse_distance + d(2);
  const Eigen::Vector3d h_G = l.direction + d(0) * e1 + d(1) * e2 + rho * (l.anchor - x.p_GI);
  const Eigen::Quaterniond q_GI(x.q_GI_wxyz(0), x.q_GI_wxyz(1), x.q_GI_wxyz(2), x.q_GI_wxyz(3));
  return camera.R_CI * (q_GI.conjugate() * h_G) + rho * camera.p_CI;
}

Eigen::Vector2d image(const CameraCalibration& camera, const CoreState& x, const CoreLandmark& l,
                      const Eigen::Vector3d& d) {
  return distort(camera, in_camera(camera, x, l, d).hnormalized());
}

Track track_of(const CoreKept& kept, const std::vector<TrackResidual>& points, const Calibration& calibration,
               const CoreModel& model) {
  Track out;
  const std::vector<Eigen::Vector2d> r_px = residuals_px(points, model);
  const auto n = static_cast<Eigen::Index>(points.size());
  out.r.resize(n, 2);
  out.J.resize(n, 6);
  for (Eigen::Index i = 0; i < n; ++i) {
    const CorePoint* const z = points[static_cast<std::size_t>(i)].measured;
    const CoreState& x = kept.keyframes[static_cast<std::size_t>(z->keyframe)];
    const CoreLandmark& l = kept.landmarks[static_cast<std::size_t>(z->landmark)];
    const CameraCalibration& camera = calibration.cameras[static_cast<std::size_t>(z->camera)];
    out.t_s.push_back(1e-9 * static_cast<double>(x.t_ns - kept.keyframes.front().t_ns));
    out.r.row(i) = r_px[static_cast<std::size_t>(i)].transpose();
    for (int c = 0; c < 3; ++c) {
      const Eigen::Vector3d d = 1e-5 * Eigen::Vector3d::Unit(c);
      const Eigen::Vector2d slope = (image(camera, x, l, d) - image(camera, x, l, -d)) / 2e-5;
      for (int axis = 0; axis < 2; ++axis) out.J(i, 3 * axis + c) = slope(axis);
    }
  }
  const CorePoint& first = *points.front().measured;
  const CoreLandmark& landmark = kept.landmarks[static_cast<std::size_t>(first.landmark)];
  const double sigma = landmark.inverse_distance < 0 ? behind_inverse_depth_sigma
                       : kept.turned_only            ? model.turned_inverse_depth_sigma
                                                     : model.inverse_depth_sigma;
  // From the camera of this track: another may have seen the landmark first, a baseline away.
  const Eigen::Vector3d h =
      in_camera(calibration.cameras[static_cast<std::size_t>(first.camera)],
                kept.keyframes[static_cast<std::size_t>(first.keyframe)], landmark, Eigen::Vector3d::Zero());
  out.depth_information = 1 / (sigma * sigma * h.squaredNorm());
  return out;
}

std::vector<Track> tracks_of(const std::vector<CoreKept>& kept, const Calibration& calibration,
                             const CoreModel& model) {
  std::vector<Track> out;
  for (const CoreKept& segment : kept) {
    for (const auto& [key, points] : tracks_of_segment(segment)) {
      if (points.size() >= 3) out.push_back(track_of(segment, points, calibration, model));
    }
  }
  return out;
}

/// px^2, of the walk's steps: the first point has none.
Eigen::VectorXd steps(const Track& track, double walk) {
  Eigen::VectorXd out = Eigen::VectorXd::Zero(track.r.rows());
  for (Eigen::Index i = 1; i < out.size(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    out(i) = walk * walk * (track.t_s[k] - track.t_s[k - 1]);
  }
  return out;
}

Whitening whitening(const Eigen::VectorXd& step, const Weights& w, const TrackNoise& noise) {
  return {step.cwiseQuotient(w.step), noise.white_px * noise.white_px * w.point.cwiseInverse()};
}

Weights weights_of(const Track& track, const TrackNoise& noise, double huber) {
  const Eigen::Index n = track.r.rows();
  const Eigen::VectorXd step = steps(track, noise.walk_px_per_sqrt_s);
  Weights w{Eigen::VectorXd::Ones(n), Eigen::VectorXd::Ones(n)};
  for (int round = 0; round < 10; ++round) {
    const auto drift = whitening(step, w, noise).walk_in(track.r);
    for (Eigen::Index i = 0; i < n; ++i) {
      const double e = (track.r.row(i) - drift.row(i)).norm() / noise.white_px;
      w.point(i) = std::min(1.0, huber / e);
      if (i > 0) w.step(i) = std::min(1.0, huber * std::sqrt(step(i)) / (drift.row(i) - drift.row(i - 1)).norm());
    }
  }
  return w;
}

/// Twice the negative logarithm of the restricted likelihood.
double cost_of(const Track& track, const Weights& w, const TrackNoise& noise) {
  const Whitening whiten = whitening(steps(track, noise.walk_px_per_sqrt_s), w, noise);
  const auto J = whiten(track.J);
  const auto r = whiten(track.r);
  Eigen::Matrix3d H = Eigen::Vector3d(0, 0, track.depth_information).asDiagonal();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  for (Eigen::Index i = 0; i < r.rows(); ++i) {
    for (int axis = 0; axis < 2; ++axis) {
      const Eigen::RowVector3d Ji = J.block<1, 3>(i, 3 * axis);
      H += Ji.transpose() * Ji;
      b += Ji.transpose() * r(i, axis);
    }
  }
  const double cost = r.squaredNorm() + 2 * whiten.log_determinant();
  const Eigen::LLT<Eigen::Matrix3d> place(H);
  return cost - b.dot(place.solve(b)) + 2 * place.matrixLLT().diagonal().array().log().sum();
}

/// Goes to the best of four neighbours until there is none, in ever smaller steps of the logarithms. Where it came from
/// is no better, and is not asked again; beside a bound the way back leads past that.
TrackNoise most_likely(const std::vector<Track>& tracks, const std::vector<Weights>& weights, TrackNoise at) {
  const auto total = [&](const TrackNoise& noise) {
    double sum = 0;
    for (std::size_t i = 0; i < tracks.size(); ++i) sum += cost_of(tracks[i], weights[i], noise);
    return sum;
  };
  double least = total(at);
  int back = -1;  // neighbours 0 and 1, 2 and 3 are each other's ways back
  for (double factor = 1.5; factor > 1.01;) {
    const std::array<std::pair<double, double>, 4> neighbours{
        {{factor, 1}, {1 / factor, 1}, {1, factor}, {1, 1 / factor}}};
    TrackNoise best = at;
    int way = -1;
    for (int k = 0; k < 4; ++k) {
      if (k == back) continue;
      const auto& [white, walk] = neighbours[static_cast<std::size_t>(k)];
      const TrackNoise trial{std::max(kLeastWhite_px, white * at.white_px),
                             std::max(kLeastWalk, walk * at.walk_px_per_sqrt_s), 0};
      const double cost = total(trial);
      if (!(cost < least)) continue;
      least = cost;
      best = trial;
      way = k;
    }
    at = best;
    const bool bound = at.white_px == kLeastWhite_px || at.walk_px_per_sqrt_s == kLeastWalk;
    back = way < 0 || bound ? -1 : way ^ 1;
    if (way < 0) factor = std::sqrt(factor);
  }
  return at;
}

}  // namespace

TrackNoise estimate_track_noise(const std::vector<CoreKept>& kept, const Calibration& calibration,
                                const CoreModel& model) {
  constexpr std::size_t kFewest = 30;  // tracks: each variance to a tenth or so
  const std::vector<Track> tracks = tracks_of(kept, calibration, model);
  TrackNoise noise{0.3, 0.5, 0};
  if (tracks.size() < kFewest) return TrackNoise{};
  for (int round = 0; round < 4; ++round) {
    std::vector<Weights> weights;
    for (const Track& track : tracks) weights.push_back(weights_of(track, noise, model.huber));
    const TrackNoise before = noise;
    noise = most_likely(tracks, weights, before);
    if (noise.white_px == before.white_px && noise.walk_px_per_sqrt_s == before.walk_px_per_sqrt_s) break;
  }
  for (const Track& track : tracks) noise.points += static_cast<int>(track.t_s.size());
  if (noise.walk_px_per_sqrt_s <= kLeastWalk) noise.walk_px_per_sqrt_s = 0;
  return noise;
}

TrackNoise to_weigh_by(const TrackNoise& shown) {
  constexpr double kLeast_px = 0.1;
  const double white2 = shown.white_px * shown.white_px, least_walk2 = kLeast_px * kLeast_px - white2;
  return {shown.white_px, std::max(shown.walk_px_per_sqrt_s, std::sqrt(std::max(0.0, least_walk2))), shown.points};
}

bool is_clearly_less(const TrackNoise& noise, const CoreModel& stated) {
  constexpr double kLess = 0.8;
  return noise.points > 0 && std::hypot(noise.white_px, noise.walk_px_per_sqrt_s) <
                                 kLess * std::hypot(stated.pixel_sigma, stated.track_walk);
}

bool differs(const TrackNoise& noise, const CoreModel& stated) {
  const double total = std::hypot(stated.pixel_sigma, stated.track_walk), enough = 0.2 * total;
  if (!stated.weighs_walks)
    return noise.points > 0 && std::abs(std::hypot(noise.white_px, noise.walk_px_per_sqrt_s) - total) > enough;
  return noise.points > 0 && (std::abs(noise.white_px - stated.pixel_sigma) > enough ||
                              std::abs(noise.walk_px_per_sqrt_s - stated.track_walk) > enough);
}

}  // namespace host
