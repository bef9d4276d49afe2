// The world that is rendered: a room with walls around the motion, and furniture in it. All faces are planes across an
// axis of G, so that a ray meets them by one division each.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "../simulate/trajectory.h"
#include "photographs.h"
#include "texture.h"

namespace host::render {

/// How one face is painted.
struct Paint {
  int texture = 0;       ///< index into Room::textures
  float s0 = 0, t0 = 0;  ///< texels, where the face's picture begins
  float brightness = 1;  ///< of the light that falls on it, about 1
};

/// A box; faces are low x, high x, low y, high y, low z, high z.
struct Block {
  Eigen::AlignedBox3f bounds;  ///< m, in G minus Room::origin_G
  Paint paint[6];
};

struct Room {
  Eigen::Vector3d origin_G = Eigen::Vector3d::Zero();  ///< m: coordinates near zero keep their digits in float
  float texels_per_m = 330;
  std::vector<Texture> textures;
  Block walls;                   ///< seen from inside
  std::vector<Block> furniture;  ///< seen from outside
};

/// A room around the motion between t_begin and t_end, s, with furniture that keeps 0.5 m away from it: a few metres
/// wide for motion in one place, a hall with partitions along the way for a walk.
Room make_room(const sim::Trajectory& truth, double t_begin, double t_end, const Photographs& photographs,
               std::uint64_t seed);

/// The face across `axis` (0 to 2) on the low or high side.
inline int face_of(int axis, bool high) { return 2 * axis + (high ? 1 : 0); }

/// Place on a face in texels: the coordinates along the two other axes.
inline void texel_of(const Room& room, const Paint& paint, int axis, const Eigen::Vector3f& p, float& s, float& t) {
  s = paint.s0 + room.texels_per_m * p[axis == 0 ? 1 : 0];
  t = paint.t0 + room.texels_per_m * p[axis == 2 ? 1 : 2];
}

}  // namespace host::render
