// Copies of kept segments, calibrated by themselves (CoreSide).
#pragma once

#include <memory>

#include "api/handle.h"
#include "replay/core_side.h"

namespace host {
namespace SEGCAL_NS {

namespace core = ::SEGCAL_NS;

/// As Core::side. Throws InputError where the device keeps none of these segments.
std::unique_ptr<CoreSide> side_of(const core::CDevice& device, const std::vector<std::uint32_t>& serials,
                                  const std::vector<double>& expected);

}  // namespace SEGCAL_NS
}  // namespace host
