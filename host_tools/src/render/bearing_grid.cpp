#include "bearing_grid.h"

#include <Eigen/Geometry>
#include <cmath>
#include <optional>

#include "../simulate/camera_model.h"

namespace host::render {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int rounds = 20;
constexpr double converged_px = 1e-9;

/// The pixel that the effects move to `pixel`: they move by little, so that a fixed point is found at once.
Vector2d before_effects(const CameraCalibration& camera, const sim::Effects& effects, const Vector2d& pixel) {
  Vector2d ideal = pixel;
  for (int round = 0; round < rounds && !effects.empty(); ++round) {
    Vector2d moved = ideal;
    for (const auto& effect : effects) effect->on_pixel(camera, 0, moved);
    ideal += pixel - moved;
    if ((pixel - moved).norm() < converged_px) break;
  }
  return ideal;
}

/// Bearings of all pixel centres and of a frame of one pixel around them.
class Centres {
 public:
  Centres(const CameraCalibration& camera, const sim::Effects& effects) : stride_(camera.width + 2) {
    for (int v = -1; v <= camera.height; ++v)
      for (int u = -1; u <= camera.width; ++u)
        bearings_.push_back(sim::bearing_of(camera, before_effects(camera, effects, Vector2d(u, v))));
  }
  const std::optional<Vector3d>& at(int u, int v) const {
    return bearings_[static_cast<std::size_t>(v + 1) * static_cast<std::size_t>(stride_) +
                     static_cast<std::size_t>(u + 1)];
  }

 private:
  int stride_;
  std::vector<std::optional<Vector3d>> bearings_;
};

}  // namespace

BearingGrid::BearingGrid(const CameraCalibration& camera, const sim::Effects& effects)
    : width_(camera.width), height_(camera.height) {
  const Centres centres(camera, effects);
  for (auto& place : bearings_)
    place.assign(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_), Bearing{0, 0, 1, 0});
  std::size_t i = 0;
  for (int v = 0; v < height_; ++v) {
    for (int u = 0; u < width_; ++u, ++i) {
      const auto &here = centres.at(u, v), &left = centres.at(u - 1, v), &right = centres.at(u + 1, v),
                 &up = centres.at(u, v - 1), &down = centres.at(u, v + 1);
      if (!here || !left || !right || !up || !down) continue;
      // Within a pixel a bearing is linear to 1e-5 px.
      const Vector3d along_u = (*right - *left) / 2, along_v = (*down - *up) / 2;
      const auto angle = static_cast<float>(std::sqrt(along_u.cross(along_v).norm()));
      for (int k = 0; k < places_per_pixel; ++k) {
        const Eigen::Vector3f b = (*here + place_u[k] * along_u + place_v[k] * along_v).cast<float>();
        bearings_[k][i] = {b.x(), b.y(), b.z(), angle};
      }
    }
  }
}

}  // namespace host::render
