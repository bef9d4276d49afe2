// Where the pixels of a camera look: computed once per calibration, used for each image.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "../calibration_file.h"
#include "../simulate/effect.h"

namespace host::render {

/// Places in a pixel at which its light is gathered, px from its
/// centre: each in a row and a column of its own (a rotated grid).
constexpr int places_per_pixel = 4;
constexpr float place_u[places_per_pixel] = {-0.375f, 0.125f, -0.125f, 0.375f};
constexpr float place_v[places_per_pixel] = {-0.125f, -0.375f, 0.375f, 0.125f};

/// A ray of the camera.
struct Bearing {
  float x, y, z;  ///< in C, unit length
  float angle;    ///< rad per px around it; 0: the lens has no ray there, the pixel is black
};

class BearingGrid {
 public:
  BearingGrid() = default;
  /// The inverse of the lens model and, before it, of the effects that move pixels (at time 0).
  BearingGrid(const CameraCalibration& camera, const sim::Effects& effects);

  int width() const { return width_; }
  int height() const { return height_; }
  /// The bearings of row v at one of the places in its pixels.
  const Bearing* row(int place, int v) const {
    return bearings_[place].data() + static_cast<std::size_t>(v) * static_cast<std::size_t>(width_);
  }

 private:
  int width_ = 0, height_ = 0;
  std::vector<Bearing> bearings_[places_per_pixel];
};

}  // namespace host::render
