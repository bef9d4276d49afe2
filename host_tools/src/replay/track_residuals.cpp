#include "replay/track_residuals.h"

#include <cmath>

namespace host {

// The core gives residuals in the order of the points, without those that are rejected or have no image.
std::map<std::pair<int, int>, std::vector<TrackResidual>> tracks_of_segment(const CoreKept& kept) {
  std::map<std::pair<int, int>, std::vector<TrackResidual>> tracks;
  auto residual = kept.points.begin();
  for (const CorePoint& z : kept.measured) {
    if (residual == kept.points.end()) break;
    const bool same =
        kept.keyframes[static_cast<std::size_t>(z.keyframe)].t_ns == residual->t_ns && z.camera == residual->camera;
    if (z.rejected || !same) continue;
    tracks[{z.landmark, z.camera}].push_back({&z, &*residual++});
  }
  return tracks;
}

// Whitened residuals are the innovations of a Kalman filter of the walk: run forward again, what it predicted is added.
std::vector<Eigen::Vector2d> residuals_px(const std::vector<TrackResidual>& track, const CoreModel& model) {
  std::vector<Eigen::Vector2d> out;
  const double white = model.pixel_sigma * model.pixel_sigma, walk = model.track_walk * model.track_walk;
  double known = 0;
  Eigen::Vector2d walked(0, 0);
  for (std::size_t i = 0; i < track.size(); ++i) {
    const double step_s = i > 0 ? 1e-9 * static_cast<double>(track[i].residual->t_ns - track[i - 1].residual->t_ns) : 0;
    const double before = i > 0 ? known + walk * step_s : 0;
    const Eigen::Vector2d innovation =
        std::sqrt(before + white) * Eigen::Vector2d(track[i].residual->u_sigma, track[i].residual->v_sigma);
    out.push_back(walked + innovation);
    walked += before / (before + white) * innovation;
    known = before * white / (before + white);
  }
  return out;
}

std::vector<Eigen::Vector2d> residuals_px(const CoreKept& kept, const CoreModel& model) {
  std::vector<Eigen::Vector2d> out(kept.points.size(), Eigen::Vector2d::Zero());
  for (const auto& [key, track] : tracks_of_segment(kept)) {
    const std::vector<Eigen::Vector2d> r_px = residuals_px(track, model);
    for (std::size_t i = 0; i < track.size(); ++i)
      out[static_cast<std::size_t>(track[i].residual - kept.points.data())] = r_px[i];
  }
  return out;
}

}  // namespace host
