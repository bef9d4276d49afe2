// Where the residuals have structure, without and with the effects that were found.
#pragma once

#include "diagnose/diagnose.h"

namespace host::diagnosis {

/// `after`: the fit with everything that was accepted; the one before is in `out`. Effects whose cause the residuals
/// still follow lose their names (held_out_report.h).
void report_structure(const std::vector<Recording>& sessions, const ReplayResult& after, Diagnosis* out);

}  // namespace host::diagnosis
