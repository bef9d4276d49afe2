#include "replay/temperature_use.h"

#include <algorithm>

#include "imu_temperature.h"

namespace host {

bool is_of_temperature(const std::string& parameter) {
  const std::size_t colon = parameter.find(':');
  return parameter.find("_temperature.") != std::string::npos ||
         (colon != std::string::npos && parameter.find('T', colon) != std::string::npos);
}

void refuse_temperature(const std::vector<Recording>& sessions, ReplayResult* result) {
  const auto bad = std::find_if(sessions.begin(), sessions.end(), [](const Recording& r) {
    return r.imu.temperature_jumps.count > 0 && !r.imu.temperature_jumps.bridged;
  });
  const std::vector<CoreParameter>& all = result->result.parameters;
  const bool used =
      std::any_of(all.begin(), all.end(), [](const CoreParameter& p) { return is_of_temperature(p.name); });
  if (bad == sessions.end() || !used || result->result.status != "calibrated") return;
  result->result.status = "insufficient";
  result->calibration = result->start;
  result->cause = temperature_words(bad->imu);
}

}  // namespace host
