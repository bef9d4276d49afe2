#include "replay/core.h"

namespace host {

// One per profile, from profile/core_of_profile.cpp.
std::unique_ptr<Core> make_core_segcal_mcu(const CoreOptions& options);
std::unique_ptr<Core> make_core_segcal_mobile(const CoreOptions& options);
std::unique_ptr<Core> make_core_segcal_host(const CoreOptions& options);
std::unique_ptr<Core> make_core_segcal_mobile_double(const CoreOptions& options);

std::unique_ptr<Core> make_core(const std::string& profile, const CoreOptions& options) {
  if (profile == "mcu") return make_core_segcal_mcu(options);
  if (profile == "mobile") return make_core_segcal_mobile(options);
  if (profile == "host") return make_core_segcal_host(options);
  if (profile == "mobile_double") return make_core_segcal_mobile_double(options);
  throw InputError("--profile: expected mcu, mobile, host or mobile_double, found '" + profile + "'");
}

}  // namespace host
