#include "imu_noise_file.h"

#include "yaml_file.h"

namespace host {
namespace {

namespace fs = std::filesystem;

/// The entry under EuRoC's or Kalibr's name; it must be positive, since the core divides by it.
double positive(const YamlFile& yaml, const YAML::Node& node, const char* euroc_name, const char* kalibr_name) {
  const char* const name = node[euroc_name].IsDefined() ? euroc_name : kalibr_name;
  if (!node[name].IsDefined())
    yaml.fail(node, std::string("an entry '") + euroc_name + "' or '" + kalibr_name + "' here");
  const double value = yaml.number(node, name);
  if (!(value > 0)) yaml.fail(node[name], std::string("a number above 0 for '") + name + "'");
  return value;
}

}  // namespace

ImuNoise read_noise_file(const fs::path& file) {
  return read_yaml(file, [](const YamlFile& yaml) {
    // Kalibr's results put everything under `imu0:`, its input files do not.
    const YAML::Node node = yaml.root()["imu0"].IsDefined() ? yaml.root()["imu0"] : yaml.root();
    ImuNoise noise;
    noise.rate_hz = positive(yaml, node, "rate_hz", "update_rate");
    noise.gyro_noise_density = positive(yaml, node, "gyroscope_noise_density", "gyroscope_noise_density");
    noise.gyro_random_walk = positive(yaml, node, "gyroscope_random_walk", "gyroscope_random_walk");
    noise.accel_noise_density = positive(yaml, node, "accelerometer_noise_density", "accelerometer_noise_density");
    noise.accel_random_walk = positive(yaml, node, "accelerometer_random_walk", "accelerometer_random_walk");
    return noise;
  });
}

ImuNoise read_recording_noise(const fs::path& root) {
  const fs::path places[] = {root / "mav0" / "imu0" / "sensor.yaml", root / "imu.yaml",
                             root / "dso" / "imu_config.yaml"};
  for (const fs::path& file : places)
    if (fs::exists(file)) return read_noise_file(file);
  throw InputError(places[0].string() + ": file is missing: expected rate_hz and the four noise figures of the IMU");
}

}  // namespace host
