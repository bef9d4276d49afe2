#include "scene.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "angles.h"
#include "random.h"

namespace host::sim {
namespace {

using Box = Eigen::AlignedBox3d;
using Points = std::vector<Eigen::Vector3d>;

constexpr double largest_room = 7;  // m, extent of the motion above which there are several rooms
constexpr double clearance = 0.75;  // m, furniture keeps this distance from the path
constexpr int wall_points = 1500;
constexpr int objects = 45;
constexpr int points_per_object = 25;
constexpr double corridor_points_per_metre = 45;

Points sample_path(const Trajectory& truth, double t_begin, double t_end, double step) {
  Points path;
  for (double t = t_begin; t <= t_end; t += step) path.push_back(truth.at(t).p_GI);
  return path;
}

Box bounds_of(const Points& path) {
  Box box;
  for (const Eigen::Vector3d& p : path) box.extend(p);
  return box;
}

double distance_to(const Points& path, const Eigen::Vector3d& point) {
  double smallest = 1e9;
  for (const Eigen::Vector3d& p : path) smallest = std::min(smallest, (p - point).squaredNorm());
  return std::sqrt(smallest);
}

Eigen::Vector3d inside(Random& random, const Box& box) {
  const double x = random.uniform(), y = random.uniform(), z = random.uniform();
  return box.min() + Eigen::Vector3d(x, y, z).cwiseProduct(box.sizes());
}

/// A point on one of the six faces, each face as often as its area asks for.
Eigen::Vector3d on_walls(Random& random, const Box& box) {
  const Eigen::Vector3d size = box.sizes();
  const Eigen::Vector3d area(size.y() * size.z(), size.x() * size.z(), size.x() * size.y());
  double draw = random.uniform(0, area.sum());
  int axis = 0;
  while (axis < 2 && draw > area[axis]) draw -= area[axis++];
  Eigen::Vector3d point = inside(random, box);
  point[axis] = random.uniform() < 0.5 ? box.min()[axis] : box.max()[axis];
  return point;
}

/// Walls at different distances on every side, so that depth varies over the image.
Points room_around(const Points& path, Random& random) {
  Box room = bounds_of(path);
  for (int axis = 0; axis < 3; ++axis) {
    room.min()[axis] -= axis == 2 ? random.uniform(1.1, 1.5) : random.uniform(1.3, 2.6);
    room.max()[axis] += axis == 2 ? random.uniform(1.1, 1.5) : random.uniform(1.3, 2.6);
  }
  Points points;
  for (int i = 0; i < wall_points; ++i) points.push_back(on_walls(random, room));
  for (int i = 0; i < objects; ++i) {
    const Eigen::Vector3d centre = inside(random, room);
    const double size = random.uniform(0.15, 0.4);
    for (int j = 0; j < points_per_object; ++j) {
      const Eigen::Vector3d point = centre + random.normal3(size / 2);
      if (room.contains(point) && distance_to(path, point) > clearance) points.push_back(point);
    }
  }
  return points;
}

/// Somewhere on the walls, floor or ceiling beside a point of the path, in a tube of varying width.
Eigen::Vector3d beside(Random& random, const Eigen::Vector3d& p) {
  const double angle = random.uniform(0, 2 * pi);
  const double width = random.uniform(1.1, 3.5), height = random.uniform(1.0, 1.6);
  const double x = std::cos(angle), z = std::sin(angle);
  // The outline of a rectangle, seen from its middle under the drawn angle.
  const double reach = std::min(width / std::max(std::abs(x), 1e-6), height / std::max(std::abs(z), 1e-6));
  const double course = random.uniform(0, 2 * pi);
  return p + reach * Eigen::Vector3d(x * std::cos(course), x * std::sin(course), z);
}

/// A walker passes through rooms: points stand around the whole path, and those that the path itself crosses later
/// are taken out. What is near enough to be seen through an open door is kept: nothing hides anything.
Points corridors_along(const Points& path, Random& random) {
  Points points;
  double due = 0;
  for (std::size_t k = 1; k < path.size(); ++k) {
    due += corridor_points_per_metre * (path[k] - path[k - 1]).norm();
    for (; due >= 1; due -= 1) {
      const Eigen::Vector3d point = beside(random, path[k]);
      if (distance_to(path, point) > clearance) points.push_back(point);
    }
  }
  // The ends of the way would look into emptiness otherwise.
  for (const Eigen::Vector3d& end : {path.front(), path.back()})
    for (int i = 0; i < 250; ++i) points.push_back(beside(random, end));
  return points;
}

}  // namespace

std::vector<Eigen::Vector3d> make_scene(const Trajectory& truth, double t_begin, double t_end, std::uint64_t seed) {
  Random random(seed, Stream::scene);
  const Points path = sample_path(truth, t_begin, t_end, 0.2);
  if (bounds_of(path).sizes().maxCoeff() < largest_room) return room_around(path, random);
  return corridors_along(path, random);
}

}  // namespace host::sim
