// Recordings as a device log, as if a device of a profile had made it.
#pragma once

#include "replay/core.h"

namespace host {

/// The file's bytes: configuration, and for each session its calls; a recording that
/// no device made is fed as `segcal replay` does it, flushed and calibrated at its
/// end. Throws InputError for a profile or a configuration that does not go together.
std::vector<std::uint8_t> device_log_of(const std::vector<Recording>& sessions, const CoreOptions& options,
                                        const std::string& profile);

}  // namespace host
