#include "replay/provenance.h"

#include <algorithm>

#include "csv.h"
#include "files/sha256.h"
#include "yaml_file.h"

namespace host {
namespace {

namespace fs = std::filesystem;

std::string text_or_empty(const YamlFile& yaml, const char* key) {
  return yaml.root()[key] ? yaml.text(yaml.root(), key) : "";
}

/// Files of a recording that a replay reads, relative to it; those that may be missing among them.
std::vector<std::string> files_read(int n_cameras) {
  std::vector<std::string> files = {
      "camchain-imucam.yaml", "imu.yaml",     "mav0/imu0/data.csv", "mav0/imu0/sensor.yaml",
      "dso/imu_config.yaml",  "dso/imu.yaml", "dso/camchain.yaml"};
  for (int c = 0; c < n_cameras; ++c) {
    const std::string camera = "mav0/cam" + std::to_string(c);
    files.push_back(camera + "/sensor.yaml");
    files.push_back(camera + "/tracks.csv");
  }
  std::sort(files.begin(), files.end());
  return files;
}

const char* name_of(CornerNoise noise) {
  return noise == CornerNoise::stated ? "stated" : noise == CornerNoise::estimated ? "estimated" : "shown";
}

}  // namespace

Provenance device_of(const fs::path& recording) {
  const fs::path file = recording / "device.yaml";
  if (!fs::exists(file)) return {};
  return read_yaml(file, [](const YamlFile& yaml) {
    Provenance out;
    out.device_id = text_or_empty(yaml, "device_id");
    out.device_model = text_or_empty(yaml, "device_model");
    return out;
  });
}

std::string sha256_of_log(const fs::path& log, int n_cameras) {
  if (!fs::is_directory(log)) return sha256_of_text(read_file(log));
  std::string lines;
  for (const std::string& file : files_read(n_cameras)) {
    if (fs::exists(log / file)) lines += sha256_of_text(read_file(log / file)) + "  " + file + "\n";
  }
  return sha256_of_text(lines);
}

std::string sha256_of_logs(const std::vector<LogIdentity>& logs) {
  if (logs.size() == 1) return logs[0].sha256;
  std::string lines;
  for (const LogIdentity& log : logs) lines += log.sha256 + "\n";
  return sha256_of_text(lines);
}

std::string sha256_of_rates(const ImuData& imu) {
  std::string bytes;
  for (const ImuSample& sample : imu.samples)
    bytes.append(reinterpret_cast<const char*>(sample.gyro.data()), 3 * sizeof(double));
  return sha256_of_text(bytes);
}

std::optional<std::array<double, 2>> temperature_range(const std::vector<Recording>& sessions) {
  std::optional<std::array<double, 2>> range;
  for (const Recording& session : sessions) {
    if (!session.imu.has_temperature) continue;
    for (const ImuSample& sample : session.imu.samples) {
      const double t = sample.temperature_degC;
      if (!(t > -273.15 && t < 1000)) continue;  // a fault of the data: NaN, or no temperature
      if (!range) range = {t, t};
      *range = {std::min((*range)[0], t), std::max((*range)[1], t)};
    }
  }
  return range;
}

nlohmann::ordered_json configuration_json(const ReplayOptions& options) {
  const CoreOptions& core = options.core;
  nlohmann::ordered_json json = {{"profile", options.profile}};
  if (!core.device_config.empty()) {  // a device's own: its bytes say all
    const auto* bytes = reinterpret_cast<const char*>(core.device_config.data());
    json["device_config_sha256"] = sha256_of_text({bytes, core.device_config.size()});
    return json;
  }
  json.update({{"cameras", core.calibration.cameras.size()},
               {"metric", core.metric},
               {"segments", segments_kept(options.profile, core.segments)},
               {"segment_s", core.segment_s},
               {"adaptive_segments", core.adaptive_segments},
               {"gravity", core.gravity > 0 ? nlohmann::ordered_json(core.gravity) : nlohmann::ordered_json()},
               {"strategy", core.multi_session ? "multi" : "single"},
               {"pixel_sigma", core.pixel_sigma},
               {"track_walk", core.track_walk},
               {"corner_noise", name_of(options.corner_noise)},
               {"seed", core.seed},
               {"trigger_sigma", core.trigger_fraction},
               {"keep_outdated", core.outdated_level < 0},
               {"condense", core.condense},
               {"hold_calibration", core.hold_calibration},
               {"joint_ekf", options.joint_ekf},
               {"calibrate", options.calibrate},
               {"passes", options.passes}});
  return json;
}

}  // namespace host
