#include "sensor.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace host::render {
namespace {

constexpr double grey_per_light = 0.85;  // at gain 1 and the usual exposure: photographs have a mean of 120
constexpr double wanted_mean_grey = 105;
constexpr double control_time_s = 0.15;
constexpr double shortest = 0.5, longest = 2;  // of the usual exposure
constexpr double least_gain = 0.5, most_gain = 4;
// a table read from random places is as good as fresh draws here, and ten times as fast
constexpr std::size_t normal_table = 1u << 16;

}  // namespace

Sensor::Sensor(const SensorOptions& options, std::uint64_t seed)
    : options_(options), exposure_s_(options.exposure_s), random_(seed, sim::Stream::pixels) {
  for (std::size_t i = 0; i < normal_table; ++i) normals_.push_back(static_cast<float>(random_.normal()));
}

void Sensor::control(double mean_light, double since_last_s) {
  if (!options_.control_exposure || !(mean_light > 0)) return;
  const double product = gain_ * exposure_s_ / options_.exposure_s;
  const double wanted = wanted_mean_grey / (grey_per_light * mean_light);
  const double next = product * std::pow(wanted / product, 1 - std::exp(-since_last_s / control_time_s));
  exposure_s_ = options_.exposure_s * std::clamp(next, shortest, longest);
  gain_ = std::clamp(next * options_.exposure_s / exposure_s_, least_gain, most_gain);
}

cv::Mat Sensor::image_of(cv::Mat light, double since_last_s) {
  if (options_.lens_blur_px > 0) cv::GaussianBlur(light, light, {5, 5}, options_.lens_blur_px);
  const auto grey_of_light = static_cast<float>(grey_per_light * gain_ * exposure_s_ / options_.exposure_s);
  // Half of the variance at grey 128 is the read-out's, half the
  // photons', which grows with the light; the gain acts on both.
  const auto variance = static_cast<float>(options_.noise_grey * options_.noise_grey / 2);
  const auto read_out = static_cast<float>(variance * gain_ * gain_),
             photons = static_cast<float>(variance * gain_ / 128);
  cv::Mat image(light.size(), CV_8UC1);
  for (int v = 0; v < light.rows; ++v) {
    const auto start = static_cast<std::size_t>(random_.integer(0, static_cast<int>(normal_table) - 1));
    const float* const from = light.ptr<float>(v);
    std::uint8_t* const to = image.ptr<std::uint8_t>(v);
    for (int u = 0; u < light.cols; ++u) {
      const float grey = grey_of_light * from[u];
      const float noisy =
          grey + std::sqrt(read_out + photons * grey) * normals_[(start + static_cast<std::size_t>(u)) % normal_table];
      to[u] = static_cast<std::uint8_t>(std::clamp(noisy + 0.5f, 0.0f, 255.0f));
    }
  }
  control(cv::mean(light)[0], since_last_s);
  return image;
}

}  // namespace host::render
