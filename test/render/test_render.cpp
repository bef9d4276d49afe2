// The renderer against the projection model: corners of a
// checker texture, found in the image, against projected points.
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "../support/cases.h"
#include "render/renderer.h"
#include "render/sensor.h"
#include "simulate/camera_model.h"
#include "simulate/device.h"
#include "simulate/effects_camera.h"
#include "simulate/random.h"
#include "simulate/scenarios.h"

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int square_texels = 128, texture_side = 1024;
constexpr float texels_per_m = 330;
const host::DistortionModel lenses[] = {host::DistortionModel::fov, host::DistortionModel::radtan,
                                        host::DistortionModel::equidistant};

void bearings_are_the_inverse_of_the_projection() {
  host::sim::Random random(11, host::sim::Stream::scene);
  for (const auto lens : lenses) {
    const auto nominal = host::sim::nominal_device(lens, 1);
    for (int device = 1; device <= 3; ++device) {
      const host::CameraCalibration camera =
          host::sim::draw_device(nominal, static_cast<std::uint64_t>(device), 1).cameras[0];
      int checked = 0;
      for (int i = 0; i < 500; ++i) {
        const Vector2d pixel(random.uniform(1, camera.width - 2), random.uniform(1, camera.height - 2));
        const auto bearing = host::sim::bearing_of(camera, pixel);
        const test::Id id = test::Id().add("lens", host::distortion_name(lens)).add("device", device).add("point", i);
        if (!bearing) continue;  // beyond 88 degrees
        const auto back = host::sim::project(camera, 2.5 * *bearing, 0);
        if (!back) continue;  // beyond 80 degrees the forward model is not asked
        ++checked;
        test::check_near(id, "pixel after the way there and back", 0, (*back - pixel).norm(),
                         1e-8);  // px; Newton stops at 1e-12 in angle
      }
      TEST_ASSERT_GREATER_THAN(400, checked);
    }
  }
}

/// A room of 4 m x 5 m x 3 m, all walls and one piece of furniture checkered.
host::render::Room checkered_room() {
  cv::Mat checker(texture_side, texture_side, CV_8UC1);
  for (int y = 0; y < texture_side; ++y)
    for (int x = 0; x < texture_side; ++x)
      checker.at<std::uint8_t>(y, x) = (x / square_texels + y / square_texels) % 2 ? 200 : 50;
  host::render::Room room;
  room.texels_per_m = texels_per_m;
  room.origin_G = {0.1, -0.2, 0.3};
  room.textures.emplace_back(checker);
  room.walls.bounds = Eigen::AlignedBox3f(Eigen::Vector3f(-2, -2.5f, -1.5f), Eigen::Vector3f(2, 2.5f, 1.5f));
  host::render::Block box;
  box.bounds = Eigen::AlignedBox3f(Eigen::Vector3f(1.2f, -0.5f, -1.5f), Eigen::Vector3f(1.8f, 0.7f, 0.2f));
  room.furniture.push_back(box);
  return room;
}

/// All corners of squares on the room's walls, in G.
std::vector<std::pair<Vector3d, int>> wall_corners(const host::render::Room& room) {
  std::vector<std::pair<Vector3d, int>> corners;
  for (int axis = 0; axis < 3; ++axis) {
    const int a = axis == 0 ? 1 : 0, b = axis == 2 ? 1 : 2;
    for (const bool high : {false, true})
      for (int i = -20; i < 20; ++i)
        for (int j = -20; j < 20; ++j) {
          Eigen::Vector3f p;
          p[axis] = high ? room.walls.bounds.max()[axis] : room.walls.bounds.min()[axis];
          // Texel k is the square from k - 0.5 to k + 0.5.
          p[a] = (static_cast<float>(i * square_texels) - 0.5f) / texels_per_m;
          p[b] = (static_cast<float>(j * square_texels) - 0.5f) / texels_per_m;
          if (room.walls.bounds.contains(p)) corners.emplace_back(room.origin_G + p.cast<double>(), axis);
        }
  }
  return corners;
}

struct Shot {
  const char* name;
  double line_delay_s, exposure_s;
  bool columns = false;
};

struct View {
  host::CameraCalibration camera;
  const host::sim::Trajectory& truth;
  double t, line_delay_s;

  Vector3d in_camera(const Vector3d& p_G, double when) const {
    const auto state = truth.at(when);
    return camera.R_CI * (state.R_GI.transpose() * (p_G - state.p_GI)) + camera.p_CI;
  }
  /// Where the corner is seen, and the line decides when. Empty near the image's edge.
  std::optional<Vector2d> pixel(const Vector3d& p_G) const {
    double when = t;
    std::optional<Vector2d> found;
    for (int round = 0; round < 6; ++round) {
      found = host::sim::project(camera, in_camera(p_G, when), 16);
      if (!found) return found;
      when = t +
             line_delay_s * (camera.reads_columns ? found->x() - camera.width / 2.0 : found->y() - camera.height / 2.0);
    }
    return found;
  }
};

/// The corner can be measured: nothing in front, squares of at least 30 px on every
/// side, seen at less than 55 degrees from the normal, and within 60 degrees of the
/// axis, beyond which a lens bends the squares' edges too much for the corner finder.
bool is_measurable(const host::render::Room& room, const View& view, const Vector3d& corner, int axis,
                   const Vector2d& pixel) {
  const auto state = view.truth.at(view.t);
  const Vector3d from = state.p_GI - state.R_GI * view.camera.R_CI.transpose() * view.camera.p_CI;
  const Vector3d ray = corner - from;
  const Vector3d in_camera = view.in_camera(corner, view.t);
  if (std::abs(ray[axis]) < 0.57 * ray.norm() || in_camera.z() < 0.5 * in_camera.norm()) return false;
  const auto& box = room.furniture[0].bounds;
  for (double s = 0.02; s < 1; s += 0.02)
    if (box.exteriorDistance((from + s * ray - room.origin_G).cast<float>().eval()) < 0.15f) return false;
  for (int a = 0; a < 3; ++a) {
    if (a == axis) continue;
    for (const double side : {-1.0, 1.0}) {
      const Vector3d next = corner + side * square_texels / texels_per_m * Vector3d::Unit(a);
      if (!room.walls.bounds.contains((next - room.origin_G).cast<float>().eval())) return false;
      const auto neighbour = view.pixel(next);
      if (!neighbour || (*neighbour - pixel).norm() < 30) return false;
    }
  }
  return true;
}

struct Errors {
  int n = 0;
  Vector2d mean = Vector2d::Zero();
  double rms = 0;
};

Errors corner_errors(host::DistortionModel lens, const Shot& shot) {
  auto device = host::sim::draw_device(host::sim::nominal_device(lens, 1), 4, 1);
  device.cameras[0].reads_columns = shot.columns;
  const auto truth = host::sim::make_trajectory("arvr", 20, 4);
  host::sim::Effects effects;
  if (shot.line_delay_s != 0) effects.push_back(std::make_shared<host::sim::RollingShutter>(shot.line_delay_s));
  const host::render::Room room = checkered_room();
  host::render::Renderer renderer(room, device.cameras[0], 0, truth, effects, host::sim::no_warm_up());
  Errors errors;
  cv::Mat light, image;
  for (double t = 1; t < 19; t += 1.5) {
    renderer.render(t, shot.exposure_s, light);
    light.convertTo(image, CV_8U);
    const View view{device.cameras[0], truth, t, shot.line_delay_s};
    for (const auto& [corner, axis] : wall_corners(room)) {
      const auto pixel = view.pixel(corner);
      if (!pixel || !is_measurable(room, view, corner, axis, *pixel)) continue;
      std::vector<cv::Point2f> found{{static_cast<float>(pixel->x()), static_cast<float>(pixel->y())}};
      cv::cornerSubPix(image, found, {7, 7}, {-1, -1}, {cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 60, 1e-4});
      const Vector2d error(found[0].x - pixel->x(), found[0].y - pixel->y());
      ++errors.n;
      errors.mean += error;
      errors.rms += error.squaredNorm() / 2;
    }
  }
  errors.mean /= errors.n;
  errors.rms = std::sqrt(errors.rms / errors.n);
  return errors;
}

/// 0.05 px is the limit for a corner. The mean of all, where the corner finder's own scatter averages out, shows a
/// wrong convention (half a pixel, half an exposure, half a texel) at once.
void corners_are_where_the_projection_says() {
  for (const auto lens : lenses) {
    for (const Shot& shot : {Shot{"global", 0, 0}, Shot{"rolling", 6e-5, 0}, Shot{"global_blurred", 0, 0.008},
                             Shot{"rolling_blurred", 6e-5, 0.008}, Shot{"columns", 4e-5, 0, true}}) {
      if (shot.columns && lens != lenses[0]) continue;  // the lens has no part in it
      const Errors e = corner_errors(lens, shot);
      const test::Id id = test::Id().add("lens", host::distortion_name(lens)).add("shutter", shot.name);
      std::printf("%s: %d corners, rms %.4f px, mean %.4f %.4f px\n", id.text().c_str(), e.n, e.rms, e.mean.x(),
                  e.mean.y());
      test::check_between(id, "corners", 30, e.n, 1e6);
      test::check_between(id, "rms error per axis, px", 0, e.rms, 0.05);
      test::check_near(id, "mean error in u, px", 0, e.mean.x(), 0.01);
      test::check_near(id, "mean error in v, px", 0, e.mean.y(), 0.01);
    }
  }
}

/// Noise as stated at grey 128, and an exposure control that reaches its aim from a dark scene.
void sensor_is_as_stated() {
  host::render::SensorOptions options;
  options.control_exposure = false;
  options.lens_blur_px = 0;
  options.noise_grey = 3;
  host::render::Sensor still(options, 5);
  cv::Scalar mean, deviation;
  cv::meanStdDev(still.image_of(cv::Mat(480, 640, CV_32FC1, cv::Scalar(128 / 0.85)), 0.1), mean, deviation);
  TEST_ASSERT_DOUBLE_WITHIN(0.05, 128, mean[0]);  // 307200 pixels average 3 grey values to 0.005
  TEST_ASSERT_DOUBLE_WITHIN(0.06, std::sqrt(9 + 1 / 12.0), deviation[0]);  // eight bits add a twelfth
  options.control_exposure = true;
  host::render::Sensor controlled(options, 5);
  double grey = 0;
  for (int k = 0; k < 60; ++k)
    grey = cv::mean(controlled.image_of(cv::Mat(480, 640, CV_32FC1, cv::Scalar(30)), 0.05))[0];
  TEST_ASSERT_DOUBLE_WITHIN(3, 105, grey);  // 3 s, seven time constants
  TEST_ASSERT_DOUBLE_WITHIN(1e-9, 2 * options.exposure_s,
                            controlled.exposure_s());  // all the time it may take, then gain
}

}  // namespace

extern "C" void setUp() {}
extern "C" void tearDown() {}

int main(int argc, char** argv) {
  test::select_cases(argc, argv);
  UNITY_BEGIN();
  RUN_TEST(bearings_are_the_inverse_of_the_projection);
  RUN_TEST(corners_are_where_the_projection_says);
  RUN_TEST(sensor_is_as_stated);
  return UNITY_END();
}
