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

/// An effect whose own cause the residuals still follow when it is in the model has not explained them: it loses its name.
/// `left`: structure of the residuals of the last fit.
void refuse_where_structure_is_left(const std::vector<Structure>& left, Diagnosis* out);

}  // namespace host::diagnosis
