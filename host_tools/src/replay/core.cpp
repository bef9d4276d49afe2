#include "replay/core.h"

namespace host {

// One per profile, from profile/core_of_profile.cpp.
namespace segcal_mcu_core {
std::unique_ptr<Core> make_core(const CoreOptions& options);
}
namespace segcal_mobile_core {
std::unique_ptr<Core> make_core(const CoreOptions& options);
}
namespace segcal_host_core {
std::unique_ptr<Core> make_core(const CoreOptions& options);
}
namespace segcal_mobile_double_core {
std::unique_ptr<Core> make_core(const CoreOptions& options);
}

std::unique_ptr<Core> make_core(const std::string& profile, const CoreOptions& options) {
  if (profile == "mcu") return segcal_mcu_core::make_core(options);
  if (profile == "mobile") return segcal_mobile_core::make_core(options);
  if (profile == "host") return segcal_host_core::make_core(options);
  if (profile == "mobile_double") return segcal_mobile_double_core::make_core(options);
  throw InputError("--profile: expected mcu, mobile, host or mobile_double, found '" + profile + "'");
}

}  // namespace host
