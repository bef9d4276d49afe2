// What a device of this profile says, in the host's own structures (replay/core.h).
#pragma once

#include "replay/profile/config_of_profile.h"

namespace host {
namespace SEGCAL_NS {

CoreState state_of(const segcal_state_t& s);
CoreSegment segment_of(const segcal_segment_t& s);
/// `n`: parameters that the direction has weights for.
CoreDirection direction_of(const segcal_direction_t& d, int n);
/// "insufficient" and empty while there is no result.
CoreResult result_of(segcal_t* device);
/// The kept segment of a slot, with all that the last calibration had of it.
CoreKept kept_of(const segcal_t* device, int slot, const segcal_segment_t& s);
/// By name.
std::vector<std::pair<std::string, std::uint32_t>> counters_of(const segcal_t* device);

}  // namespace SEGCAL_NS
}  // namespace host
