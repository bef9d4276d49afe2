// What a simulation leaves on disk: the recording, the calibration to start from, and the truth to compare with.
#include <nlohmann/json.hpp>

#include "../file_output.h"
#include "device.h"
#include "simulate.h"

namespace host {
namespace {

std::string truth_json(const SimulationResult& result) {
  nlohmann::ordered_json json;
  json["format"] = 1;
  json["parameters"] = nlohmann::ordered_json::array();
  for (const sim::NamedParameter& parameter : sim::named_parameters(result.truth, result.imu_is_simulated))
    json["parameters"].push_back({{"name", parameter.name}, {"value", parameter.value}});
  json["effects"] = nlohmann::ordered_json::array();
  for (const sim::EffectTruth& effect : result.effects) {
    nlohmann::ordered_json parameters = nlohmann::ordered_json::array();
    for (const auto& p : effect.parameters)
      parameters.push_back({{"name", p.name}, {"value", p.value}, {"unit", p.unit}});
    json["effects"].push_back({{"name", effect.name}, {"parameters", parameters}});
  }
  return json.dump(1) + "\n";
}

void append_vector(std::string& text, const Eigen::Vector3d& v) {
  for (int i = 0; i < 3; ++i) {
    text += ',';
    append_number(text, v[i]);
  }
}

std::string biases_csv(const SimulationResult& result) {
  std::string text = "#timestamp [ns],b_w_x [rad s^-1],b_w_y,b_w_z,b_a_x [m s^-2],b_a_y,b_a_z\n";
  for (const ImuSample& sample : result.recording.imu.samples) {
    const sim::Biases biases = result.state_at(sample.t_ns).biases;
    append_number(text, sample.t_ns);
    append_vector(text, biases.gyro);
    append_vector(text, biases.accel);
    text += '\n';
  }
  return text;
}

}  // namespace

void write_simulation(const SimulationResult& result, const std::filesystem::path& root) {
  Recording recording = result.recording;
  recording.root = root;
  if (result.with_images) recording.cameras.clear();
  write_recording(recording);
  write_camchain(root / "camchain-imucam.yaml", result.nominal);
  write_file(root / "device.yaml",
             "device_id: simulated-" + std::to_string(result.device_seed) + "\ndevice_model: simulated\n");
  write_camchain(root / "truth" / "camchain-imucam.yaml", result.truth);
  write_file(root / "truth" / "truth.json", truth_json(result));
  if (!result.imu_is_simulated) return;
  write_imu_yaml(root / "truth" / "imu.yaml", result.truth, result.recording.imu.noise);
  write_file(root / "truth" / "biases.csv", biases_csv(result));
}

}  // namespace host
