// What the held-out gap says of the accepted effects: which of them get a name.
#pragma once

#include "diagnose/diagnose.h"
#include "diagnose/evidence.h"
#include "diagnose/gap.h"

namespace host::diagnosis {

struct HeldOut {
  const Selection& selection;
  const std::vector<TermInfo>& terms;
  Floor floor;
};

/// Excess before and after, and effects with a name. `last`: the fit with everything that was accepted.
void report_gap(const HeldOut& held_out, const ReplayResult& last, Diagnosis* out);

/// Variance components: what the mean square is above the stated one, without and with the factor.
void add_noise_gap(const std::vector<DiagnosedEffect>& noise, Diagnosis* out);

}  // namespace host::diagnosis
