// Where a result comes from: which device, which log, which
// program, which configuration. With it a result stands alone.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>

#include "replay/replay.h"

namespace host {

struct LogIdentity {
  std::string name;    ///< last part of its path
  std::string sha256;  ///< 64 hexadecimal digits, see sha256_of_log
};

struct Provenance {
  std::string device_id, device_model;                   ///< empty: not known
  std::vector<LogIdentity> logs;                         ///< one for each recording, in order
  std::optional<std::vector<LogIdentity>> earlier_logs;  ///< that the state had seen before; none: no state
  bool begins_with_state = false;                        ///< the device's, which its log begins with
  nlohmann::ordered_json configuration = nlohmann::ordered_json::object();
  std::optional<std::array<double, 2>> temperature_degC;  ///< lowest and highest; none: the logs do not tell it
};

/// What a recording's device.yaml says (device_id, device_model; docs/formats.md); empty texts without that file.
Provenance device_of(const std::filesystem::path& recording);

/// Of a file: as sha256sum prints it. Of a folder: of the lines "DIGITS  PATH\n" of all files that a replay with that
/// many cameras reads, in the order of their paths.
std::string sha256_of_log(const std::filesystem::path& log, int n_cameras);
/// Of all logs of a result: the digits of the one, or of the text of all digits, a line each.
std::string sha256_of_logs(const std::vector<LogIdentity>& logs);

/// Of a recording's rotation rates, all bits.
std::string sha256_of_rates(const ImuData& imu);

std::optional<std::array<double, 2>> temperature_range(const std::vector<Recording>& sessions);

/// What was chosen, by the names of the options of `segcal replay`.
nlohmann::ordered_json configuration_json(const ReplayOptions& options);

}  // namespace host
