// From light to grey values: exposure control, noise, eight bits.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "../simulate/random.h"

namespace host::render {

struct SensorOptions {
  double exposure_s = 0.005;     ///< in light of usual brightness; the control goes from half of it to twice
  double noise_grey = 2;         ///< standard deviation at a grey value of 128 and gain 1, half read-out, half photons
  double lens_blur_px = 0.5;     ///< standard deviation of the lens' point spread
  bool control_exposure = true;  ///< false: exposure and gain stay
};

/// One camera's sensor. The exposure control works as cameras do it: it looks at the last image and goes part of the
/// way, first by the time, then by the gain.
class Sensor {
 public:
  Sensor(const SensorOptions& options, std::uint64_t seed);

  /// For the next image.
  double exposure_s() const { return exposure_s_; }

  /// 8-bit grey from the light (render::Renderer), `since_last_s` after the last image.
  cv::Mat image_of(cv::Mat light, double since_last_s);

 private:
  void control(double mean_light, double since_last_s);

  SensorOptions options_;
  double exposure_s_, gain_ = 1;
  std::vector<float> normals_;
  sim::Random random_;
};

}  // namespace host::render
