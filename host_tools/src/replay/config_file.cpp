#include "replay/config_file.h"

#include <algorithm>
#include <cmath>

#include "calibration/prior.h"
#include "file_output.h"
#include "gravity.h"
#include "yaml_file.h"

namespace host {
namespace {

struct PriorEntry {
  const char* name;
  double PriorSigmas::*sigma;
  const char* unit;
};
constexpr PriorEntry kPriors[] = {
    {"r_CI_rad", &PriorSigmas::r_CI_rad, "rad, each axis of the camera's rotation"},
    {"p_CI_m", &PriorSigmas::p_CI_m, "m, each axis of the lever arm"},
    {"focal_length_share", &PriorSigmas::focal_length_share, "of f"},
    {"principal_point_px", &PriorSigmas::principal_point_px, "px"},
    {"distortion", &PriorSigmas::distortion,
     "each coefficient of the lens; by default 0.03 (fov), 0.1 (radtan), 0.02 (equidistant)"},
    {"gyro_scale", &PriorSigmas::gyro_scale, "of 1"},
    {"gyro_misalignment", &PriorSigmas::gyro_misalignment, "rad"},
    {"accel_scale", &PriorSigmas::accel_scale, "of 1"},
    {"accel_misalignment", &PriorSigmas::accel_misalignment, "rad"},
    {"r_AI_rad", &PriorSigmas::r_AI_rad, "rad, each axis of the accelerometer's rotation"},
};

struct NoiseEntry {
  const char* name;
  std::optional<double> SensorConfig::*value;
  double least, most;  // what the core takes
  const char* unit;
};
constexpr NoiseEntry kNoise[] = {
    {"gyroscope_noise_density", &SensorConfig::gyro_noise_density, 1e-9, 1, "rad/s/sqrt(Hz)"},
    {"gyroscope_random_walk", &SensorConfig::gyro_random_walk, 1e-9, 1, "rad/s^2/sqrt(Hz)"},
    {"accelerometer_noise_density", &SensorConfig::accel_noise_density, 1e-9, 10, "m/s^2/sqrt(Hz)"},
    {"accelerometer_random_walk", &SensorConfig::accel_random_walk, 1e-9, 10, "m/s^3/sqrt(Hz)"},
    {"pixel_sigma_px", &SensorConfig::pixel_sigma, 1e-3, 100, "px, white noise of a tracked corner per axis"},
    {"track_walk_px_per_sqrt_s", &SensorConfig::track_walk, 0, 100,
     "px/sqrt(s), random walk of its error along the track"},
};

constexpr double kLeastGravity = 1, kMostGravity = 30;  // from the Moon to Jupiter; 980.665 or 1 g are other units

double number_in(const YamlFile& yaml, const YAML::Node& node, const char* name, double least, double most) {
  const double value = yaml.number(node, name);
  if (value >= least && value <= most) return value;
  std::string range = "a number from ";
  append_number(range, least);
  range += " to ";
  append_number(range, most);
  yaml.fail(node[name], range + " for '" + name + "'");
}

/// A word that nobody reads is a mistake of the one who wrote it.
template <class Known>
void refuse_unknown(const YamlFile& yaml, const YAML::Node& node, const std::string& where, const Known& known) {
  if (!node.IsMap()) yaml.fail(node, "a map of names and numbers for '" + where + "'");
  for (const auto& entry : node) {
    const std::string name = entry.first.Scalar();
    if (std::find(known.begin(), known.end(), name) != known.end()) continue;
    std::string all;
    for (const std::string& k : known) all += (all.empty() ? "" : ", ") + k;
    yaml.fail(entry.first, "one of " + all + (where.empty() ? "" : " in '" + where + "'") + ", found '" + name + "'");
  }
}

template <class Entries>
std::vector<std::string> names_of(const Entries& entries) {
  std::vector<std::string> out;
  for (const auto& entry : entries) out.push_back(entry.name);
  return out;
}

double read_gravity(const YamlFile& yaml, const YAML::Node& node) {
  refuse_unknown(yaml, node, "gravity", std::vector<std::string>{"m_s2", "latitude_deg", "height_m"});
  const bool by_place = node["latitude_deg"].IsDefined();
  if (by_place == node["m_s2"].IsDefined())
    yaml.fail(node, "either 'm_s2' or 'latitude_deg' with 'height_m' for 'gravity'");
  if (!by_place) {
    if (node["height_m"].IsDefined()) yaml.fail(node["height_m"], "'height_m' beside 'latitude_deg' only");
    return number_in(yaml, node, "m_s2", kLeastGravity, kMostGravity);
  }
  const double latitude = number_in(yaml, node, "latitude_deg", -90, 90);
  return normal_gravity(latitude, node["height_m"].IsDefined() ? number_in(yaml, node, "height_m", -1000, 20000) : 0);
}

/// The core's defaults for a device with this camera alone: its entries, then the IMU's fifteen.
std::vector<double> default_sigmas(const CameraCalibration& camera) {
  SEGCAL_NS::Calibration<double> mean;
  mean.n_cameras = 1;
  mean.camera[0].model = static_cast<SEGCAL_NS::Distortion>(camera.model);
  mean.camera[0].intrinsics = camera.intrinsics;
  std::vector<double> out(static_cast<std::size_t>(mean.columns()));
  SEGCAL_NS::default_prior_sigmas(mean, out.data());
  return out;
}

/// What is stated, and the core's defaults for the rest. Lenses of two kinds have no default in common.
PriorSigmas effective(const PriorSigmas& stated, const Calibration& start) {
  const CameraCalibration& first = start.cameras.front();
  const std::vector<double> all = default_sigmas(first);
  const double* const imu = all.data() + all.size() - 15;
  const bool one_lens =
      std::all_of(start.cameras.begin(), start.cameras.end(), [&](const auto& c) { return c.model == first.model; });
  PriorSigmas out{all[0], all[3], all[6] / first.intrinsics(0), all[8], one_lens ? all[10] : 0, imu[0], imu[3], imu[6],
                  imu[9], imu[12]};
  for (const PriorEntry& entry : kPriors)
    if (stated.*entry.sigma > 0) out.*entry.sigma = stated.*entry.sigma;
  return out;
}

void append_entry(std::string* text, const char* name, double value, const char* unit) {
  *text += "  ";
  append_yaml_entry(*text, name, value, unit);
}

}  // namespace

std::vector<double> prior_sigmas(const PriorSigmas& stated, const Calibration& start) {
  std::vector<double> out;
  const auto put = [&out](int n, double sigma, double by_default) {
    // A default that is stated stays the core's own, in the core's precision: the same bits.
    const bool changed = sigma > 0 && std::abs(sigma - by_default) > 1e-9 * by_default;
    out.insert(out.end(), static_cast<std::size_t>(n), changed ? sigma : 0);
  };
  for (const CameraCalibration& camera : start.cameras) {
    const std::vector<double> by_default = default_sigmas(camera);
    put(3, stated.r_CI_rad, by_default[0]);
    put(3, stated.p_CI_m, by_default[3]);
    put(1, stated.focal_length_share * camera.intrinsics(0), by_default[6]);
    put(1, stated.focal_length_share * camera.intrinsics(1), by_default[7]);
    put(2, stated.principal_point_px, by_default[8]);
    put(static_cast<int>(by_default.size()) - 25, stated.distortion, by_default[10]);
  }
  const std::vector<double> by_default = default_sigmas(start.cameras.front());
  const double* const imu = by_default.data() + by_default.size() - 15;
  put(3, stated.gyro_scale, imu[0]);
  put(3, stated.gyro_misalignment, imu[3]);
  put(3, stated.accel_scale, imu[6]);
  put(3, stated.accel_misalignment, imu[9]);
  put(3, stated.r_AI_rad, imu[12]);
  return out;
}

void SensorConfig::apply(CoreOptions* options) const {
  for (const PriorEntry& entry : kPriors)
    if (prior_sigma.*entry.sigma > 0) options->prior_sigma.*entry.sigma = prior_sigma.*entry.sigma;
  const auto take = [](const std::optional<double>& stated, double* to) { *to = stated.value_or(*to); };
  take(gravity, &options->gravity);
  take(gyro_noise_density, &options->noise.gyro_noise_density);
  take(gyro_random_walk, &options->noise.gyro_random_walk);
  take(accel_noise_density, &options->noise.accel_noise_density);
  take(accel_random_walk, &options->noise.accel_random_walk);
  take(pixel_sigma, &options->pixel_sigma);
  take(track_walk, &options->track_walk);
}

SensorConfig read_config_file(const std::filesystem::path& file) {
  return read_yaml(file, [](const YamlFile& yaml) {
    const YAML::Node& root = yaml.root();
    refuse_unknown(yaml, root, "", std::vector<std::string>{"format", "prior_sigma", "gravity", "noise"});
    if (yaml.number_or(root, "format", 1) != 1) yaml.fail(root["format"], "'format: 1'");
    SensorConfig out;
    if (const YAML::Node priors = root["prior_sigma"]) {
      refuse_unknown(yaml, priors, "prior_sigma", names_of(kPriors));
      for (const PriorEntry& entry : kPriors)
        if (priors[entry.name].IsDefined())
          out.prior_sigma.*entry.sigma =
              number_in(yaml, priors, entry.name, SEGCAL_NS::kLeastSigma, SEGCAL_NS::kMostSigma);
    }
    if (const YAML::Node gravity = root["gravity"]) out.gravity = read_gravity(yaml, gravity);
    if (const YAML::Node noise = root["noise"]) {
      refuse_unknown(yaml, noise, "noise", names_of(kNoise));
      for (const NoiseEntry& entry : kNoise)
        if (noise[entry.name].IsDefined())
          out.*entry.value = number_in(yaml, noise, entry.name, entry.least, entry.most);
    }
    return out;
  });
}

std::string config_yaml(const CoreOptions& options) {
  std::string text =
      "# What this replay believed of the sensors: segcal replay --config takes it.\nformat: 1\nprior_sigma:\n";
  const PriorSigmas priors = effective(options.prior_sigma, options.calibration);
  for (const PriorEntry& entry : kPriors)
    if (priors.*entry.sigma > 0) append_entry(&text, entry.name, priors.*entry.sigma, entry.unit);
  text += options.gravity > 0 ? "gravity:\n" : "# Nobody stated it, the standard value was taken:\n# gravity:\n#";
  append_entry(&text, "m_s2", options.gravity > 0 ? options.gravity : kStandardGravity, "m/s^2");
  text += "noise:\n";
  const double values[] = {options.noise.gyro_noise_density,
                           options.noise.gyro_random_walk,
                           options.noise.accel_noise_density,
                           options.noise.accel_random_walk,
                           options.pixel_sigma,
                           options.track_walk};
  for (std::size_t i = 0; i < std::size(kNoise); ++i) append_entry(&text, kNoise[i].name, values[i], kNoise[i].unit);
  return text;
}

std::string config_help() {
  CoreOptions options;
  options.gravity = kStandardGravity;
  options.calibration.cameras.resize(1);
  options.calibration.cameras[0].intrinsics << 1, 1, 0, 0;
  options.calibration.cameras[0].model = DistortionModel::radtan;
  std::string text =
      R"(--config reads the assumptions about the sensors. Every entry is optional; a missing one has the value shown here, noise the value
of the recording's sensor.yaml. Instead of gravity's m_s2: latitude_deg and height_m (WGS 84). OUT/config.yaml holds the values
used and can be the next run's --config; --pixel-sigma and --track-walk override the file.
)";
  std::string example = config_yaml(options);
  return text + example.substr(example.find('\n') + 1);
}

}  // namespace host
