// Corners that cannot be of the image that the calibration is for.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "diagnose/fault.h"
#include "quantile.h"

namespace host {
namespace {

constexpr std::size_t least_points = 1000;
// share of points outside: images of twice the size have 3/4 there, a lens far from its model 1/20
constexpr double most_beyond = 0.25;
constexpr double corner_share = 0.55;  // of width and height: images of half the size reach half of them
constexpr double almost_all = 0.999;

std::string rounded(double value) {
  char text[40];
  std::snprintf(text, sizeof text, "%.0f", value);
  return text;
}

void check_camera(const CameraData& data, const CameraCalibration& camera, const std::string& name,
                  std::vector<Fault>& out) {
  if (camera.width < 1 || camera.height < 1) return;  // a device log does not know it
  std::vector<double> u, v;
  std::size_t beyond = 0;
  for (const Frame& frame : data.frames) {
    for (const TrackPoint& p : frame.points) {
      if (!std::isfinite(p.u) || !std::isfinite(p.v)) continue;
      u.push_back(p.u);
      v.push_back(p.v);
      beyond += p.u < -0.5 || p.v < -0.5 || p.u > camera.width - 0.5 || p.v > camera.height - 0.5 ? 1 : 0;
    }
  }
  if (u.size() < least_points) return;
  Fault fault{"image_size", name, data.frames.front().t_ns, data.frames.back().t_ns, u.size(), 0, 0, "-", ""};
  const double outside = static_cast<double>(beyond) / static_cast<double>(u.size());
  const double reach_u = quantile(u, almost_all), reach_v = quantile(v, almost_all);
  const double reach = std::max(reach_u / camera.width, reach_v / camera.height);
  const std::string size = std::to_string(camera.width) + " x " + std::to_string(camera.height) + " px. ";
  const char* const remedy = "Scale the calibration to the size of the images, or record at that size.";
  if (outside > most_beyond) {
    fault.value = outside;
    fault.limit = most_beyond;
    fault.words =
        name + ": " + rounded(100 * outside) + " % of the corners lie outside of the calibrated " + size + remedy;
  } else if (reach < corner_share) {
    fault.value = reach;
    fault.limit = corner_share;
    fault.words = name + ": corners reach no further than " + rounded(reach_u) + " x " + rounded(reach_v) +
                  " px of the calibrated " + size + remedy;
  }
  if (!fault.words.empty()) out.push_back(fault);
}

}  // namespace

std::vector<Fault> image_faults(const Recording& recording, const Calibration& start) {
  std::vector<Fault> out;
  for (std::size_t c = 0; c < recording.cameras.size() && c < start.cameras.size(); ++c)
    check_camera(recording.cameras[c], start.cameras[c], "cam" + std::to_string(c), out);
  return out;
}

}  // namespace host
