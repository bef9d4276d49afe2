// The light that falls on a camera's sensor: rays from each pixel into the room, at several moments of its exposure.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "../simulate/effect.h"
#include "../simulate/trajectory.h"
#include "bearing_grid.h"
#include "room.h"

namespace host::render {

/// One camera in one room. Lines are exposed at their own time (Effect::exposure_time: time
/// offset, rolling shutter), for `exposure_s` around it; motion blur is the mean of 4 to 24
/// moments. Each moment looks from another place in the pixel, so that these are the samples
/// against aliasing too; a sample reads the mip level whose texels are as large as it is.
class Renderer {
 public:
  /// `room`, `truth` and `effects` must outlive this.
  Renderer(const Room& room, const CameraCalibration& camera, std::size_t index, const sim::Trajectory& truth,
           const sim::Effects& effects, const sim::WarmUp& warm_up);

  /// CV_32F, grey values of the photographs times the brightness of the face; 0 where the lens has no ray.
  /// `t` is the frame's stamp, s on the trajectory's clock.
  void render(double t, double exposure_s, cv::Mat& light);

 private:
  /// A camera's place for a line at a moment, in float relative to the room's origin.
  struct View {
    Eigen::Matrix3f R_GC;
    Eigen::Vector3f p_GC;
  };
  /// The pieces of furniture that a tile of the image may see.
  using Seen = std::vector<const Block*>;

  View view_at(double t) const;
  double line_time(double t, double line) const;
  int moments_for(double t, double exposure_s) const;
  void follow_calibration(double t);
  void find_seen(double t, double exposure_s);
  float light_from(const View& view, const Bearing& bearing, const Seen& seen, float dither) const;
  void find_views(double t, double since_middle);
  void add_row(int v, int moment, float* sum) const;

  const Room& room_;
  CameraCalibration first_camera_, camera_;  ///< before any shock; now
  std::size_t index_;
  const sim::Trajectory& truth_;
  const sim::Effects& effects_;
  sim::WarmUp warm_up_;
  BearingGrid grid_;
  int tiles_across_ = 0, tiles_down_ = 0;
  std::vector<Seen> seen_;   ///< by tile, row by row
  std::vector<View> views_;  ///< at a moment, of each line; one if all lines are exposed together
};

}  // namespace host::render
