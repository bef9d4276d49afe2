#include "device_log/write_log.h"

namespace host {

// One per profile, from replay/profile/log_of_profile.cpp.
using LogBytes = std::vector<std::uint8_t>;
LogBytes log_of_segcal_mcu(const std::vector<Recording>& sessions, const CoreOptions& options);
LogBytes log_of_segcal_mobile(const std::vector<Recording>& sessions, const CoreOptions& options);
LogBytes log_of_segcal_host(const std::vector<Recording>& sessions, const CoreOptions& options);
LogBytes log_of_segcal_mobile_double(const std::vector<Recording>& sessions, const CoreOptions& options);

LogBytes device_log_of(const std::vector<Recording>& sessions, const CoreOptions& options, const std::string& profile) {
  if (profile == "mcu") return log_of_segcal_mcu(sessions, options);
  if (profile == "mobile") return log_of_segcal_mobile(sessions, options);
  if (profile == "host") return log_of_segcal_host(sessions, options);
  if (profile == "mobile_double") return log_of_segcal_mobile_double(sessions, options);
  throw InputError("--profile: expected mcu, mobile, host or mobile_double, found '" + profile + "'");
}

}  // namespace host
