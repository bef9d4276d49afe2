// The comparison with a twin, for people and for files.
#pragma once

#include <string>

#include "twin/twin.h"

namespace host::twin {

/// A table for a terminal, 107 columns wide.
std::string as_table(const Comparison& comparison);
/// twin.json (docs/formats.md).
std::string as_json(const Comparison& comparison);

}  // namespace host::twin
