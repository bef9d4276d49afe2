// Corner tracks that cannot be of one scene: many that move unlike the rest, ids that change places, all that end at once.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <opencv2/calib3d.hpp>
#include <unordered_map>

#include "camera_geometry.h"
#include "diagnose/fault.h"
#include "quantile.h"

namespace host {
namespace {

constexpr std::size_t least_common = 12;     // corners that two images share, for a statement about the two
constexpr double apart_s = 0.8;              // a corner that creeps at 20 px/s is 16 px off by then
constexpr int most_pairs = 40;               // evenly over the recording: bounded work, some 10 ms each
constexpr double tolerated_px = 4;           // beyond corner noise, a rolling shutter and a lens that is somewhat off
constexpr double most_unlike = 0.08;         // share of corners; simulated, rendered, EuRoC's and a phone's images: 0 to 0.02, a lens that odometry fails with: 0.07
constexpr double a_jump = 0.2;               // of the image's diagonal, beside the other corners' motion, from one image to the next
constexpr double most_jumping = 0.3;         // share of corners: a few wrong matches are no mixed-up ids
constexpr double shared_at_least = 0.05;     // of an image's corners with the one before; where half are usual, fewer are a loss
constexpr double usually_shared = 0.5;
constexpr double longest_step_s = 0.25;      // beyond, corners have reason to be others

using Points = std::unordered_map<std::uint32_t, Eigen::Vector2d>;

double seconds_between(const Frame& a, const Frame& b) { return static_cast<double>(b.t_ns - a.t_ns) * 1e-9; }

template <typename... T>
std::string text(const char* format, T... values) {
  char buffer[500];
  std::snprintf(buffer, sizeof buffer, format, values...);
  return buffer;
}

Points points_of(const Frame& frame) {
  Points out;
  for (const TrackPoint& p : frame.points)
    if (std::isfinite(p.u) && std::isfinite(p.v)) out[p.track_id] = {p.u, p.v};
  return out;
}

/// Corners of both frames in the first's order, pixels.
void common_points(const Frame& a, const Frame& b, std::vector<Eigen::Vector2d>* of_a, std::vector<Eigen::Vector2d>* of_b) {
  const Points in_b = points_of(b);
  for (const TrackPoint& p : a.points) {
    const auto match = in_b.find(p.track_id);
    if (match == in_b.end() || !std::isfinite(p.u) || !std::isfinite(p.v)) continue;
    of_a->push_back({p.u, p.v});
    of_b->push_back(match->second);
  }
}

struct Share {
  std::size_t of = 0, all = 0;
  double value() const { return all > 0 ? static_cast<double>(of) / static_cast<double>(all) : 0; }
};

/// Corners of two images, of the half that is nearer to the axis, that no motion of the camera explains: beyond the best essential matrix (Nister, "An efficient solution to
/// the five-point relative pose problem", PAMI 2004, within RANSAC), by pixels of the mean focal length. A lens that is off tells in the other half first.
Share unlike_the_rest(const Frame& a, const Frame& b, const CameraCalibration& camera) {
  std::vector<Eigen::Vector2d> pixels_a, pixels_b;
  common_points(a, b, &pixels_a, &pixels_b);
  std::vector<cv::Point2d> rays_a, rays_b;
  for (std::size_t i = 0; i < pixels_a.size(); ++i) {
    const auto x = undistort(camera, pixels_a[i]), y = undistort(camera, pixels_b[i]);
    if (!x || !y || x->norm() > 2 || y->norm() > 2) continue;   // 63 degrees from the axis: a pixel is little there
    rays_a.emplace_back(x->x(), x->y());
    rays_b.emplace_back(y->x(), y->y());
  }
  if (rays_a.size() < least_common) return {};
  cv::Mat fits;
  const double focal_px = 0.5 * (camera.intrinsics[0] + camera.intrinsics[1]);
  const cv::Mat E = cv::findEssentialMat(rays_a, rays_b, 1.0, {0, 0}, cv::RANSAC, 0.999, tolerated_px / focal_px, fits);
  if (E.empty() || fits.empty()) return {};
  std::vector<double> radius;
  radius.reserve(rays_a.size());
  for (const cv::Point2d& x : rays_a) radius.push_back(std::hypot(x.x, x.y));
  const double middle = quantile(radius, 0.5);
  Share out;
  for (std::size_t i = 0; i < rays_a.size(); ++i) {
    if (radius[i] > middle) continue;
    ++out.all;
    out.of += fits.at<std::uint8_t>(static_cast<int>(i)) == 0 ? 1 : 0;
  }
  return out;
}

bool check_motion(const std::vector<Frame>& frames, const CameraCalibration& camera, const std::string& name, std::vector<Fault>& out) {
  Share sum;
  const std::size_t step = std::max<std::size_t>(1, frames.size() / most_pairs);
  int pairs = 0;
  for (std::size_t i = 0; i < frames.size(); i += step) {
    std::size_t j = i + 1;
    while (j < frames.size() && seconds_between(frames[i], frames[j]) < apart_s) ++j;
    if (j == frames.size() || seconds_between(frames[i], frames[j]) > 2 * apart_s) continue;
    const Share share = unlike_the_rest(frames[i], frames[j], camera);
    sum.of += share.of;
    sum.all += share.all;
    pairs += share.all > 0 ? 1 : 0;
  }
  if (pairs < most_pairs / 4 || sum.value() <= most_unlike) return false;
  out.push_back({"outlier_tracks", name, frames.front().t_ns, frames.back().t_ns, sum.of, sum.value(), most_unlike, "-",
                 text("%s: %.0f %% of the corners move by over %.0f px unlike the rest within %.1f s, which no motion of the camera explains. Check matches "
                      "forwards and backwards in the tracker, mask what moves by itself, and look at the lens model if the tracks are good.",
                      name.c_str(), 100 * sum.value(), tolerated_px, apart_s)});
  return true;
}

/// Corners that jump across the image while the others do not.
Share jumping(const Frame& a, const Frame& b, double diagonal_px) {
  std::vector<Eigen::Vector2d> from, to;
  common_points(a, b, &from, &to);
  if (from.size() < least_common) return {};
  std::vector<double> du, dv;
  for (std::size_t i = 0; i < from.size(); ++i) {
    du.push_back(to[i].x() - from[i].x());
    dv.push_back(to[i].y() - from[i].y());
  }
  const Eigen::Vector2d middle(quantile(du, 0.5), quantile(dv, 0.5));
  Share out{0, from.size()};
  for (std::size_t i = 0; i < from.size(); ++i) out.of += (to[i] - from[i] - middle).norm() > a_jump * diagonal_px ? 1 : 0;
  return out;
}

/// Ids that change places, and the places where every track ends. `unlike`: many corners move unlike the rest anyway.
void check_continuity(const std::vector<Frame>& frames, double diagonal_px, bool unlike, const std::string& name, std::vector<Fault>& out) {
  std::vector<double> shared;
  std::vector<std::size_t> mixed, lost;
  for (std::size_t i = 1; i < frames.size(); ++i) {
    if (seconds_between(frames[i - 1], frames[i]) > longest_step_s) continue;
    const std::size_t most = std::min(frames[i - 1].points.size(), frames[i].points.size());
    if (most < least_common) continue;
    std::vector<Eigen::Vector2d> from, to;
    common_points(frames[i - 1], frames[i], &from, &to);
    shared.push_back(static_cast<double>(from.size()) / static_cast<double>(most));
    if (shared.back() < shared_at_least) lost.push_back(i);
    if (jumping(frames[i - 1], frames[i], diagonal_px).value() > most_jumping) mixed.push_back(i);
  }
  if (!mixed.empty() && !unlike) {
    out.push_back({"mixed_tracks", name, frames[mixed.front()].t_ns, frames[mixed.back()].t_ns, mixed.size(), static_cast<double>(mixed.size()), 0, "images",
                   text("%s: in %zu images over %.0f %% of the corners jump across the image, as if ids had changed places. An id must stay with its corner.",
                        name.c_str(), mixed.size(), 100 * most_jumping)});
  }
  if (!lost.empty() && quantile(shared, 0.5) > usually_shared) {
    out.push_back({"lost_tracks", name, frames[lost.front()].t_ns, frames[lost.back()].t_ns, lost.size(), static_cast<double>(lost.size()), 0, "images",
                   text("%s: at %zu images every track ends and others begin, though neighbouring images usually share %.0f %% of them. Did the tracker start anew? "
                        "Recordings joined end to end are sessions of their own.",
                        name.c_str(), lost.size(), 100 * quantile(shared, 0.5))});
  }
}

}  // namespace

std::vector<Fault> track_faults(const Recording& recording, const Calibration& start) {
  std::vector<Fault> out;
  for (std::size_t c = 0; c < recording.cameras.size() && c < start.cameras.size(); ++c) {
    const std::vector<Frame>& frames = recording.cameras[c].frames;
    if (frames.size() < 2) continue;
    const std::string name = "cam" + std::to_string(c);
    double reach_u = 0, reach_v = 0;
    for (const Frame& frame : frames)
      for (const TrackPoint& p : frame.points) {
        if (std::isfinite(p.u)) reach_u = std::max(reach_u, p.u);
        if (std::isfinite(p.v)) reach_v = std::max(reach_v, p.v);
      }
    const bool unlike = check_motion(frames, start.cameras[c], name, out);
    check_continuity(frames, std::hypot(reach_u, reach_v), unlike, name, out);
  }
  return out;
}

}  // namespace host
