#include "renderer.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace host::render {
namespace {

using Eigen::Vector3f;

constexpr int tile_px = 32;
constexpr float tile_margin = 0.03f;  // rad, beside what the three views of a frame cover
constexpr int fewest_moments = 4, most_moments = 24;
constexpr double px_per_moment = 0.5;  // of motion: with longer steps corners of a blurred checker scatter by 0.06 px
constexpr double usual_distance_m = 1.5;  // turns speed into image motion, for the number of moments
// A sample stands for half a pixel across the slope of a face and,
// as the places lie in rows of their own, for a third along it.
constexpr float share_across = 0.5f, share_along = 0.33f;

/// floor(log2(x)) for x >= 1: the exponent of the float.
int exponent_of(float x) {
  std::uint32_t bits;
  std::memcpy(&bits, &x, sizeof bits);
  return static_cast<int>(bits >> 23) - 127;
}

struct Hit {
  float distance;
  int axis;
  const Paint* paint;
};

void meet_walls(const Block& walls, const Vector3f& o, const Vector3f& d, const Vector3f& inverse, Hit& hit) {
  for (int axis = 0; axis < 3; ++axis) {
    const bool high = d[axis] > 0;
    const float t = ((high ? walls.bounds.max()[axis] : walls.bounds.min()[axis]) - o[axis]) * inverse[axis];
    if (t < hit.distance) hit = {t, axis, &walls.paint[face_of(axis, high)]};
  }
}

void meet_block(const Block& block, const Vector3f& o, const Vector3f& d, const Vector3f& inverse, Hit& hit) {
  float enter = 0, leave = hit.distance;
  int axis = -1;
  for (int i = 0; i < 3; ++i) {
    const float a = (block.bounds.min()[i] - o[i]) * inverse[i], b = (block.bounds.max()[i] - o[i]) * inverse[i];
    const float near = std::min(a, b);
    if (near > enter) {
      enter = near;
      axis = i;
    }
    leave = std::min(leave, std::max(a, b));
  }
  if (axis >= 0 && enter < leave) hit = {enter, axis, &block.paint[face_of(axis, d[axis] < 0)]};
}

}  // namespace

Renderer::Renderer(const Room& room, const CameraCalibration& camera, std::size_t index, const sim::Trajectory& truth,
                   const sim::Effects& effects, const sim::WarmUp& warm_up)
    : room_(room),
      first_camera_(camera),
      camera_(camera),
      index_(index),
      truth_(truth),
      effects_(effects),
      warm_up_(warm_up),
      grid_(camera, effects) {
  tiles_across_ = (camera.width + tile_px - 1) / tile_px;
  tiles_down_ = (camera.height + tile_px - 1) / tile_px;
  seen_.resize(static_cast<std::size_t>(tiles_across_) * static_cast<std::size_t>(tiles_down_));
}

Renderer::View Renderer::view_at(double t) const {
  const sim::BodyState state = truth_.at(t);
  const Eigen::Matrix3d R_GC = state.R_GI * camera_.R_CI.transpose();
  const Eigen::Vector3d p_GC = state.p_GI - R_GC * camera_.p_CI;
  return {R_GC.cast<float>(), (p_GC - room_.origin_G).cast<float>()};
}

double Renderer::line_time(double t, double line) const {
  for (const auto& effect : effects_) t = effect->exposure_time(camera_, t, line);
  return t;
}

int Renderer::moments_for(double t, double exposure_s) const {
  const sim::BodyState state = truth_.at(t);
  const double px = exposure_s * camera_.intrinsics.x() * (state.w_GI.norm() + state.v_GI.norm() / usual_distance_m);
  const int rounds = static_cast<int>(std::ceil(px / px_per_moment / fewest_moments));
  return fewest_moments * std::clamp(rounds, 1, most_moments / fewest_moments);
}

/// A shock moves the camera, and so does temperature: then the grid is another.
void Renderer::follow_calibration(double t) {
  CameraCalibration now = first_camera_;
  for (const auto& effect : effects_) effect->on_camera_calibration({t, index_, warm_up_.at(t)}, now);
  const bool same_lens = now.intrinsics == camera_.intrinsics && now.distortion == camera_.distortion;
  camera_ = now;
  if (!same_lens) grid_ = BearingGrid(camera_, effects_);
}

/// Cones around the tiles against spheres around the furniture, for the frame's first, middle and last view.
void Renderer::find_seen(double t, double exposure_s) {
  const int h = camera_.height, w = camera_.width, lines = camera_.lines();
  const View views[] = {view_at(line_time(t, 0) - exposure_s / 2), view_at(line_time(t, lines / 2.0)),
                        view_at(line_time(t, lines - 1) + exposure_s / 2)};
  for (int i = 0; i < tiles_across_ * tiles_down_; ++i) {
    const int u0 = i % tiles_across_ * tile_px, v0 = i / tiles_across_ * tile_px;
    const int u1 = std::min(u0 + tile_px, w) - 1, v1 = std::min(v0 + tile_px, h) - 1;
    const auto bearing = [&](int u, int v) {
      const Bearing& b = grid_.row(0, v)[u];
      return Vector3f(b.x, b.y, b.z);
    };
    const Vector3f axis = bearing((u0 + u1) / 2, (v0 + v1) / 2);
    float half = 0;
    for (const auto& corner : {bearing(u0, v0), bearing(u1, v0), bearing(u0, v1), bearing(u1, v1)})
      half = std::max(half, std::acos(std::clamp(axis.dot(corner), -1.0f, 1.0f)));
    Seen& seen = seen_[static_cast<std::size_t>(i)];
    seen.clear();
    for (const Block& block : room_.furniture) {
      const float radius = block.bounds.diagonal().norm() / 2;
      const bool is_near = std::any_of(std::begin(views), std::end(views), [&](const View& view) {
        const Vector3f to = view.R_GC.transpose() * (block.bounds.center() - view.p_GC);
        const float distance = to.norm();
        if (distance <= radius) return true;
        return std::acos(std::clamp(axis.dot(to) / distance, -1.0f, 1.0f)) <
               half + std::asin(radius / distance) + tile_margin;
      });
      if (is_near) seen.push_back(&block);
    }
  }
}

inline float Renderer::light_from(const View& view, const Bearing& bearing, const Seen& seen, float dither) const {
  const Vector3f d = view.R_GC * Vector3f(bearing.x, bearing.y, bearing.z);
  const Vector3f inverse(1 / d.x(), 1 / d.y(), 1 / d.z());
  Hit hit{1e9f, 0, nullptr};
  meet_walls(room_.walls, view.p_GC, d, inverse, hit);
  for (const Block* block : seen) meet_block(*block, view.p_GC, d, inverse, hit);
  const Vector3f p = view.p_GC + hit.distance * d;
  if (!(p.cwiseAbs().maxCoeff() < 1e6f)) return 0;  // m: no ray, where the lens has none for the pixel
  float s, t;
  texel_of(room_, *hit.paint, hit.axis, p, s, t);
  const float across = hit.distance * bearing.angle * room_.texels_per_m;  // texels per px, facing the ray
  const float along = across * std::abs(inverse[hit.axis]);
  // Between two levels the samples of a pixel are shared out by `dither`, which blends the levels.
  const float texels = std::max(1.0f, dither * std::max(share_across * across, share_along * along));
  const Texture& texture = room_.textures[static_cast<std::size_t>(hit.paint->texture)];
  return hit.paint->brightness * texture.at(s, t, std::min(exponent_of(texels), texture.levels() - 1));
}

void Renderer::find_views(double t, double since_middle) {
  const int lines = camera_.lines();
  const bool together = line_time(t, 0) == line_time(t, lines - 1);
  views_.clear();
  for (int line = 0; line < (together ? 1 : lines); ++line)
    views_.push_back(view_at(line_time(t, line) + since_middle));
}

/// Neighbouring pixels take their places in another order: if all looked left first and right last, a blurred edge
/// would be displaced by hundredths of a pixel.
void Renderer::add_row(int v, int moment, float* sum) const {
  static const float dithers[places_per_pixel] = {1.0905f, 1.2968f, 1.5422f, 1.8340f};  // 2^((k + 1/2) / 4)
  const Bearing* const rows[] = {grid_.row(0, v), grid_.row(1, v), grid_.row(2, v), grid_.row(3, v)};
  const Seen* seen = seen_.data() + (v / tile_px) * tiles_across_;
  const bool together = views_.size() == 1, columns = camera_.reads_columns;
  for (int u = 0; u < grid_.width(); ++u) {
    const int place = (moment + u + 2 * v) % places_per_pixel;
    const Bearing& bearing = rows[place][u];
    if (bearing.angle == 0) continue;
    const View& view = views_[static_cast<std::size_t>(together ? 0 : columns ? u : v)];
    sum[u] += light_from(view, bearing, seen[u / tile_px], dithers[place]);
  }
}

void Renderer::render(double t, double exposure_s, cv::Mat& light) {
  follow_calibration(t);
  find_seen(t, exposure_s);
  light.create(grid_.height(), grid_.width(), CV_32FC1);
  light.setTo(0);
  const int moments = moments_for(t, exposure_s);
  for (int k = 0; k < moments; ++k) {
    find_views(t, exposure_s * ((k + 0.5) / moments - 0.5));
    for (int v = 0; v < grid_.height(); ++v) add_row(v, k, light.ptr<float>(v));
  }
  light *= 1.0 / moments;
}

}  // namespace host::render
