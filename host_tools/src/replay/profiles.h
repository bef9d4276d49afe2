// The profiles of the core in this program: what is compiled once for each is called by the profile's name.
#pragma once

#include <string>

#include "recording.h"

// F(PROFILE) for each.
#ifdef SEGCAL_WITHOUT_DOUBLE_PROFILE
#define SEGCAL_FOR_EACH_PROFILE(F) F(mcu) F(mobile) F(host)
#else
#define SEGCAL_FOR_EACH_PROFILE(F) F(mcu) F(mobile) F(host) F(mobile_double)
#endif

namespace host {

[[noreturn]] inline void refuse_profile(const std::string& found) {
#define SEGCAL_NAME(profile) names += std::string(names.empty() ? "" : ", ") + #profile;
  std::string names;
  SEGCAL_FOR_EACH_PROFILE(SEGCAL_NAME)
#undef SEGCAL_NAME
  throw InputError("--profile: expected one of " + names + ", found '" + found + "'");
}

}  // namespace host
