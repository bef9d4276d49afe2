// What the selection says of each candidate: its score, and why it was not accepted.
#pragma once

#include "diagnose/diagnose.h"
#include "diagnose/selection.h"

namespace host::diagnosis {

/// Scores of all candidates; those that were rejected, and those that nothing can be said of with what that needs.
void report_candidates(const Selection& selection, bool has_temperature, bool has_exposures, Diagnosis* out);

}  // namespace host::diagnosis
