// What the held-out gap says of the accepted effects: which of them get a name.
#pragma once

#include "diagnose/diagnose.h"
#include "diagnose/evidence.h"
#include "diagnose/sensor_gap.h"
#include "diagnose/told.h"

namespace host::diagnosis {

struct HeldOut {
  const Selection& selection;
  const std::vector<TermInfo>& terms;
  const Told& told;   ///< effects that need no folds to be there
  JoinedRows joined;  ///< of the last fit
  SensorPieces sensors;
  std::array<Floor, kSensors> floors;  ///< of the sensors' noise; the first is the whole's, too
};

/// Excess before and after, and effects with a name.
void report_gap(const HeldOut& held_out, Diagnosis* out);

/// An effect whose own cause the residuals still follow when it is in the model has not explained them: it loses its
/// name. `left`: structure of the residuals of the last fit.
void refuse_where_structure_is_left(const std::vector<Structure>& left, Diagnosis* out);

}  // namespace host::diagnosis
