#include "replay/core.h"

#include <algorithm>

#include "replay/profiles.h"

namespace host {

// One per profile, from profile/core_of_profile.cpp.
#define SEGCAL_DECLARE(profile)                                  \
  namespace segcal_##profile##_core {                            \
    std::unique_ptr<Core> make_core(const CoreOptions& options); \
    int most_segments();                                         \
  }
SEGCAL_FOR_EACH_PROFILE(SEGCAL_DECLARE)
#undef SEGCAL_DECLARE

std::unique_ptr<Core> make_core(const std::string& profile, const CoreOptions& options) {
#define SEGCAL_CALL(name) \
  if (profile == #name) return segcal_##name##_core::make_core(options);
  SEGCAL_FOR_EACH_PROFILE(SEGCAL_CALL)
#undef SEGCAL_CALL
  refuse_profile(profile);
}

int most_segments(const std::string& profile) {
#define SEGCAL_CALL(name) \
  if (profile == #name) return segcal_##name##_core::most_segments();
  SEGCAL_FOR_EACH_PROFILE(SEGCAL_CALL)
#undef SEGCAL_CALL
  refuse_profile(profile);
}

int segments_kept(const std::string& profile, int wanted) {
  return wanted > 0 ? wanted : std::min(8, most_segments(profile));
}

}  // namespace host
