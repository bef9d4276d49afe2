// What the held-out gap says of the accepted effects: which of them get a name.
#pragma once

#include <array>

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

/// A variance component: the excess of the mean square over the stated one, without the factor, and on each half of the samples with the
/// factor of the other half.
struct NoiseEffect {
  DiagnosedEffect effect;
  SensorShares before, after;
};
/// `halves`: the factor of each parameter's two halves; 0: not known, nothing counts as closed.
NoiseEffect noise_effect(const std::string& name, const std::vector<DiagnosedParameter>& factors,
                         const std::vector<std::array<double, 2>>& halves);
void add_noise_gap(const std::vector<NoiseEffect>& noise, Diagnosis* out);

}  // namespace host::diagnosis
