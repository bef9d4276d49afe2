#include "device_log/write_log.h"

namespace host {

// One per profile, from replay/profile/log_of_profile.cpp.
using LogBytes = std::vector<std::uint8_t>;
namespace segcal_mcu_core {
LogBytes log_of(const std::vector<Recording>& sessions, const CoreOptions& options);
}
namespace segcal_mobile_core {
LogBytes log_of(const std::vector<Recording>& sessions, const CoreOptions& options);
}
namespace segcal_host_core {
LogBytes log_of(const std::vector<Recording>& sessions, const CoreOptions& options);
}
namespace segcal_mobile_double_core {
LogBytes log_of(const std::vector<Recording>& sessions, const CoreOptions& options);
}

LogBytes device_log_of(const std::vector<Recording>& sessions, const CoreOptions& options, const std::string& profile) {
  if (profile == "mcu") return segcal_mcu_core::log_of(sessions, options);
  if (profile == "mobile") return segcal_mobile_core::log_of(sessions, options);
  if (profile == "host") return segcal_host_core::log_of(sessions, options);
  if (profile == "mobile_double") return segcal_mobile_double_core::log_of(sessions, options);
  throw InputError("--profile: expected mcu, mobile, host or mobile_double, found '" + profile + "'");
}

}  // namespace host
