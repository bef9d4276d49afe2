#include "device_log/write_log.h"

#include "replay/profiles.h"

namespace host {

// One per profile, from replay/profile/log_of_profile.cpp.
using LogBytes = std::vector<std::uint8_t>;
#define SEGCAL_DECLARE(profile)                                                          \
  namespace segcal_##profile##_core {                                                    \
    LogBytes log_of(const std::vector<Recording>& sessions, const CoreOptions& options); \
  }
SEGCAL_FOR_EACH_PROFILE(SEGCAL_DECLARE)
#undef SEGCAL_DECLARE

LogBytes device_log_of(const std::vector<Recording>& sessions, const CoreOptions& options, const std::string& profile) {
#define SEGCAL_CALL(name) \
  if (profile == #name) return segcal_##name##_core::log_of(sessions, options);
  SEGCAL_FOR_EACH_PROFILE(SEGCAL_CALL)
#undef SEGCAL_CALL
  refuse_profile(profile);
}

}  // namespace host
