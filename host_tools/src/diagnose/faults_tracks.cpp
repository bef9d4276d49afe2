// Corner tracks that cannot be of one scene: many that move
// unlike the rest, ids that change places, all that end at once.
#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <unordered_map>

#include "camera_geometry.h"
#include "diagnose/fault.h"
#include "formatted.h"
#include "quantile.h"

namespace host {
namespace {

constexpr std::size_t least_common = 12;  // corners that two images share, for a statement about the two
constexpr double apart_s = 0.8;           // a corner that creeps at 20 px/s is 16 px off by then
constexpr int most_pairs = 40;            // evenly over the recording: bounded work, about a millisecond each
constexpr double tolerated_px = 4;        // beyond corner noise, a rolling shutter and a lens that is somewhat off
constexpr double farthest = 2;            // tangent of 63 degrees from the axis, beyond which a pixel is little
// Share of corners. Simulated, rendered, EuRoC's and a phone's images
// have 0 to 0.02; 0.07 are left by a lens that odometry fails with.
constexpr double most_unlike = 0.08;
constexpr double a_jump = 0.2;  // of the image's diagonal, beside the other corners' motion, from one image to the next
// from one image to the next; ids in reversed order look like half a turn, ids at random like a zoom to a point
constexpr double most_roll_rad = 1.2, most_zoom = 1.5;
constexpr double most_jumping = 0.3;  // share of corners: a few wrong matches are no mixed-up ids
// of an image's corners with the one before; where half are usual, fewer are a loss
constexpr double shared_at_least = 0.05;
constexpr double usually_shared = 0.5;
constexpr double longest_step_s = 0.25;  // beyond, corners have reason to be others
// intervals of the camera: beyond, an image is missing, and corners move further than from one to the next
constexpr double longest_step = 1.5;

using Points = std::unordered_map<std::uint32_t, Eigen::Vector2d>;

double seconds_between(const Frame& a, const Frame& b) { return static_cast<double>(b.t_ns - a.t_ns) * 1e-9; }

Points points_of(const Frame& frame) {
  Points out;
  for (const TrackPoint& p : frame.points)
    if (std::isfinite(p.u) && std::isfinite(p.v)) out[p.track_id] = {p.u, p.v};
  return out;
}

/// Corners that two images share, px.
struct Matches {
  std::vector<Eigen::Vector2d> from, to;
  std::size_t size() const { return from.size(); }
};

Matches matches_of(const Points& a, const Frame& b) {
  Matches out;
  for (const TrackPoint& p : b.points) {
    const auto match = a.find(p.track_id);
    if (match == a.end() || !std::isfinite(p.u) || !std::isfinite(p.v)) continue;
    out.from.push_back(match->second);
    out.to.push_back({p.u, p.v});
  }
  return out;
}

struct Share {
  std::size_t of = 0, all = 0;
  double value() const { return all > 0 ? static_cast<double>(of) / static_cast<double>(all) : 0; }
};

/// Of corners of two images, in the half that is nearer to the axis, those that no motion of the camera explains:
/// beyond the best essential matrix (Nister, "An efficient solution to the five-point relative pose problem", PAMI
/// 2004, within RANSAC), by pixels of the mean focal length. A lens that is off tells in the other half first.
Share unlike_the_rest(const Matches& pixels, const CameraCalibration& camera) {
  std::vector<cv::Point2d> from, to;
  std::vector<double> radius;
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const auto x = undistort(camera, pixels.from[i]), y = undistort(camera, pixels.to[i]);
    if (!x || !y || x->norm() > farthest || y->norm() > farthest) continue;
    from.emplace_back(x->x(), x->y());
    to.emplace_back(y->x(), y->y());
    radius.push_back(x->norm());
  }
  if (from.size() < least_common) return {};
  cv::Mat fits;
  const double focal_px = 0.5 * (camera.intrinsics[0] + camera.intrinsics[1]);
  const cv::Mat E = cv::findEssentialMat(from, to, 1.0, {0, 0}, cv::RANSAC, 0.999, tolerated_px / focal_px, fits);
  if (E.empty() || fits.empty()) return {};
  const double middle = quantile(radius, 0.5);
  Share out;
  for (std::size_t i = 0; i < from.size(); ++i) {
    if (radius[i] > middle) continue;
    ++out.all;
    out.of += fits.at<std::uint8_t>(static_cast<int>(i)) == 0 ? 1 : 0;
  }
  return out;
}

bool check_motion(const std::vector<Frame>& frames, const CameraCalibration& camera, const std::string& name,
                  std::vector<Fault>& out) {
  Share sum;
  const std::size_t step = std::max<std::size_t>(1, frames.size() / most_pairs);
  int pairs = 0;
  for (std::size_t i = 0; i < frames.size(); i += step) {
    std::size_t j = i + 1;
    while (j < frames.size() && seconds_between(frames[i], frames[j]) < apart_s) ++j;
    if (j == frames.size() || seconds_between(frames[i], frames[j]) > 2 * apart_s) continue;
    const Share share = unlike_the_rest(matches_of(points_of(frames[i]), frames[j]), camera);
    sum.of += share.of;
    sum.all += share.all;
    pairs += share.all > 0 ? 1 : 0;
  }
  if (pairs < most_pairs / 4 || sum.value() <= most_unlike) return false;
  out.push_back({"outlier_tracks", name, frames.front().t_ns, frames.back().t_ns, sum.of, sum.value(), most_unlike, "-",
                 formatted("%s: %.0f %% of the corners move by over %.0f px unlike the rest within %.1f s, which no "
                           "motion of the camera explains. Check matches forwards and backwards in the tracker, mask "
                           "what moves by itself, and look at the lens model if the tracks are good.",
                           name.c_str(), 100 * sum.value(), tolerated_px, apart_s)});
  return true;
}

/// Corners that are elsewhere than the best shift, turn and zoom of the image has them: a camera that rolls by 0.4 rad
/// from one image to the next moves the image's edges by a fifth of its diagonal. Of ids that changed places none fits.
Share beside_similarity(const Matches& pixels, double tolerance_px) {
  std::vector<cv::Point2f> from, to;
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    from.emplace_back(static_cast<float>(pixels.from[i].x()), static_cast<float>(pixels.from[i].y()));
    to.emplace_back(static_cast<float>(pixels.to[i].x()), static_cast<float>(pixels.to[i].y()));
  }
  cv::Mat fits;
  const cv::Mat A = cv::estimateAffinePartial2D(from, to, fits, cv::RANSAC, tolerance_px);
  if (A.empty() || fits.empty()) return {pixels.size(), pixels.size()};
  const double c = A.at<double>(0, 0), s = A.at<double>(1, 0), zoom = std::hypot(c, s);
  if (std::abs(std::atan2(s, c)) > most_roll_rad || zoom > most_zoom || zoom < 1 / most_zoom)
    return {pixels.size(), pixels.size()};
  return {pixels.size() - static_cast<std::size_t>(cv::countNonZero(fits)), pixels.size()};
}

/// Corners that jump across the image while the others do not.
Share jumping(const Matches& pixels, double diagonal_px) {
  if (pixels.size() < least_common) return {};
  std::vector<double> du, dv;
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    du.push_back(pixels.to[i].x() - pixels.from[i].x());
    dv.push_back(pixels.to[i].y() - pixels.from[i].y());
  }
  const double u = quantile(du, 0.5), v = quantile(dv, 0.5);
  Share out{0, pixels.size()};
  for (std::size_t i = 0; i < pixels.size(); ++i)
    out.of += std::hypot(du[i] - u, dv[i] - v) > a_jump * diagonal_px ? 1 : 0;
  return out.value() > most_jumping ? beside_similarity(pixels, a_jump * diagonal_px) : out;
}

/// s.
double usual_interval(const std::vector<Frame>& frames) {
  std::vector<double> all;
  for (std::size_t i = 1; i < frames.size(); ++i) all.push_back(seconds_between(frames[i - 1], frames[i]));
  return quantile(std::move(all), 0.5);
}

/// From one image to the next: where ids change places, where every track
/// ends, and what share of corners neighbours usually have in common.
struct Continuity {
  std::vector<std::size_t> mixed, lost;
  double shared = 0;  ///< median
};

Continuity continuity_of(const std::vector<Frame>& frames, double diagonal_px) {
  Continuity out;
  std::vector<double> shared;
  Points before = points_of(frames.front());
  const double longest_s = std::min(longest_step_s, longest_step * usual_interval(frames));
  for (std::size_t i = 1; i < frames.size(); ++i) {
    const std::size_t fewer = std::min(before.size(), frames[i].points.size());
    if (seconds_between(frames[i - 1], frames[i]) <= longest_s && fewer >= least_common) {
      const Matches pixels = matches_of(before, frames[i]);
      shared.push_back(static_cast<double>(pixels.size()) / static_cast<double>(fewer));
      if (shared.back() < shared_at_least) out.lost.push_back(i);
      if (jumping(pixels, diagonal_px).value() > most_jumping) out.mixed.push_back(i);
    }
    before = points_of(frames[i]);
  }
  if (!shared.empty()) out.shared = quantile(std::move(shared), 0.5);
  return out;
}

Fault fault_of_images(const char* kind, const std::string& name, const std::vector<Frame>& frames,
                      const std::vector<std::size_t>& at, const std::string& words) {
  return {kind,     name, frames[at.front()].t_ns, frames[at.back()].t_ns, at.size(), static_cast<double>(at.size()), 0,
          "images", words};
}

/// `unlike`: many corners move unlike the rest anyway, which need not be mixed-up ids.
void check_continuity(const std::vector<Frame>& frames, double diagonal_px, bool unlike, const std::string& name,
                      std::vector<Fault>& out) {
  const Continuity c = continuity_of(frames, diagonal_px);
  if (!c.mixed.empty() && !unlike) {
    const char* const words =
        "%s: in %zu images over %.0f %% of the corners jump across the image, as if ids had changed places. An id must "
        "stay with its corner.";
    out.push_back(fault_of_images("mixed_tracks", name, frames, c.mixed,
                                  formatted(words, name.c_str(), c.mixed.size(), 100 * most_jumping)));
  }
  if (c.lost.empty() || c.shared <= usually_shared) return;
  const char* const words =
      "%s: at %zu images every track ends and others begin, though neighbouring images usually share %.0f %% of them. "
      "Did the tracker start anew? Recordings joined end to end are sessions of their own.";
  out.push_back(fault_of_images("lost_tracks", name, frames, c.lost,
                                formatted(words, name.c_str(), c.lost.size(), 100 * c.shared)));
}

/// px; a device log does not know the images' size.
double diagonal_of(const std::vector<Frame>& frames) {
  double u = 0, v = 0;
  for (const Frame& frame : frames) {
    for (const TrackPoint& p : frame.points) {
      if (std::isfinite(p.u)) u = std::max(u, p.u);
      if (std::isfinite(p.v)) v = std::max(v, p.v);
    }
  }
  return std::hypot(u, v);
}

}  // namespace

std::vector<Fault> track_faults(const Recording& recording, const Calibration& start) {
  std::vector<Fault> out;
  for (std::size_t c = 0; c < recording.cameras.size() && c < start.cameras.size(); ++c) {
    const std::vector<Frame>& frames = recording.cameras[c].frames;
    if (frames.size() < 2) continue;
    const std::string name = "cam" + std::to_string(c);
    const bool unlike = check_motion(frames, start.cameras[c], name, out);
    check_continuity(frames, diagonal_of(frames), unlike, name, out);
  }
  return out;
}

}  // namespace host
