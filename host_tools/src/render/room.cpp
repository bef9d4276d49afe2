#include "room.h"

#include <cmath>

#include "../simulate/random.h"
#include "angles.h"
#include "wallpaper.h"

namespace host::render {
namespace {

using Eigen::Vector3d;
using Box = Eigen::AlignedBox3d;

constexpr int n_textures = 4, texture_side = 2048;  // px; at 3 mm a texel a picture repeats after 6.2 m
constexpr double largest_room = 7;                  // m, extent of the motion above which it is a walk
constexpr double clearance = 0.5;                   // m between furniture and the path
constexpr int pieces_in_a_room = 9;
constexpr double pieces_per_metre = 0.9;  // of a walk
constexpr int tries = 40;                 // to place one piece

std::vector<Vector3d> sample_path(const sim::Trajectory& truth, double t_begin, double t_end) {
  std::vector<Vector3d> path;
  for (double t = t_begin; t <= t_end; t += 0.1) path.push_back(truth.at(t).p_GI);
  return path;
}

class Builder {
 public:
  Builder(const sim::Trajectory& truth, double t_begin, double t_end, std::uint64_t seed)
      : path_(sample_path(truth, t_begin, t_end)), random_(seed, sim::Stream::scene) {
    for (const Vector3d& p : path_) hull_.extend(p);
    is_walk_ = hull_.sizes().maxCoeff() > largest_room;
  }

  Room build(const Photographs& photographs, std::uint64_t seed) {
    Room room;
    room.origin_G = hull_.center();
    for (int i = 0; i < n_textures; ++i)
      room.textures.emplace_back(
          make_wallpaper(photographs, texture_side, seed + 1000003u * static_cast<std::uint64_t>(i + 1)));
    const Box walls = around(hull_);
    room.walls = painted(walls, room.origin_G, true);
    const int pieces = is_walk_ ? static_cast<int>(pieces_per_metre * length()) : pieces_in_a_room;
    for (int i = 0; i < pieces; ++i) place_piece(walls, room);
    return room;
  }

 private:
  /// Walls at different distances on every side, so that depth varies over the image.
  Box around(Box box) {
    for (int axis = 0; axis < 3; ++axis) {
      box.min()[axis] -= axis == 2 ? random_.uniform(1.1, 1.5) : random_.uniform(1.3, 2.6);
      box.max()[axis] += axis == 2 ? random_.uniform(1.1, 1.5) : random_.uniform(1.3, 2.6);
    }
    return box;
  }

  double length() const {
    double sum = 0;
    for (std::size_t k = 1; k < path_.size(); ++k) sum += (path_[k] - path_[k - 1]).norm();
    return sum;
  }

  bool is_free(const Box& box) const {
    for (const Vector3d& p : path_)
      if (box.exteriorDistance(p) < clearance) return false;
    return true;
  }

  /// Cupboards and tables on the floor; along a walk also partitions up to the ceiling.
  void place_piece(const Box& walls, Room& room) {
    for (int i = 0; i < tries; ++i) {
      const bool tall = is_walk_ && random_.uniform() < 0.4;
      Vector3d size(random_.uniform(0.3, 1.2), random_.uniform(0.3, 1.2),
                    tall ? walls.sizes().z() : random_.uniform(0.4, 1.6));
      Vector3d centre = is_walk_ ? beside_the_path() : anywhere(walls);
      centre.z() = walls.min().z() + size.z() / 2;
      const Box box(centre - size / 2, centre + size / 2);
      if (!is_free(box)) continue;
      room.furniture.push_back(painted(box.intersection(walls), room.origin_G, false));
      return;
    }
  }

  Vector3d beside_the_path() {
    const Vector3d& p = path_[static_cast<std::size_t>(random_.integer(0, static_cast<int>(path_.size()) - 1))];
    const double angle = random_.uniform(0, two_pi), reach = random_.uniform(1.2, 3.2);
    return p + reach * Vector3d(std::cos(angle), std::sin(angle), 0);
  }

  Vector3d anywhere(const Box& walls) {
    const double x = random_.uniform(), y = random_.uniform();
    return walls.min() + Vector3d(x, y, 0).cwiseProduct(walls.sizes());
  }

  Block painted(const Box& box, const Vector3d& origin_G, bool is_room) {
    Block block;
    block.bounds = Eigen::AlignedBox3f((box.min() - origin_G).cast<float>(), (box.max() - origin_G).cast<float>());
    for (int face = 0; face < 6; ++face) {
      Paint& paint = block.paint[face];
      paint.texture = random_.integer(0, n_textures - 1);
      paint.s0 = static_cast<float>(random_.uniform(0, texture_side));
      paint.t0 = static_cast<float>(random_.uniform(0, texture_side));
      paint.brightness = static_cast<float>(random_.uniform(0.8, 1.15));
    }
    if (is_room) block.paint[random_.integer(0, 3)].brightness = 1.4f;  // the wall that the light falls on
    return block;
  }

  std::vector<Vector3d> path_;
  sim::Random random_;
  Box hull_;
  bool is_walk_ = false;
};

}  // namespace

Room make_room(const sim::Trajectory& truth, double t_begin, double t_end, const Photographs& photographs,
               std::uint64_t seed) {
  return Builder(truth, t_begin, t_end, seed).build(photographs, seed);
}

}  // namespace host::render
