// Faults of sensors, drivers, trackers and loggers, put into a clean recording: what devices meet in the field.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "recording.h"

namespace host::sim {

struct FaultKind {
  const char* name;
  const char* what;                ///< sizes and places, in words
  std::vector<std::string> names;  ///< parts of what must be reported, one of them is enough; none: nothing has to be
  std::function<void(Recording&, std::uint64_t seed)> spoil;
  std::string effect = "";  ///< of the simulated device (simulate --effect) instead; empty: none
  bool keep_clock = false;  ///< replay without looking for the camera clock's offset
};

/// The first one is no fault: what a clean recording gives.
const std::vector<FaultKind>& fault_kinds();
const FaultKind& fault_kind(const std::string& name);  ///< throws InputError
/// Of the faults themselves, for a help text, in lines: without
/// the clean recording and other ways to replay the same fault.
std::string fault_kind_names();

}  // namespace host::sim
