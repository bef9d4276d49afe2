// Terms that diagnosis can add to the model: the effects of the
// core's catalogue, and a dictionary of simple terms beyond it.
#pragma once

#include "diagnose/selection.h"
#include "replay/core.h"

namespace host::diagnosis {

/// A parameter of an effect, or a term of the dictionary.
struct TermInfo {
  CoreTerm term;
  std::string effect;      ///< empty: of the dictionary
  int bit = -1;            ///< of the effect in SEGCAL_EFFECT_*
  std::string name, unit;  ///< "time_offset.t_d"
  double size = 0;         ///< plausible magnitude
};

/// The catalogue's terms in the order of the core, and candidates that own them.
struct Catalogue {
  std::vector<TermInfo> terms;
  std::vector<Candidate> candidates;
};
Catalogue core_catalogue(bool has_temperature);

/// A term of the dictionary with its name, unit and plausible magnitude.
TermInfo term_info(const CoreTerm& term);

/// Terms that the catalogue does not have: products of two signals on each axis of the IMU, polynomials on the image.
std::vector<TermInfo> dictionary(bool has_temperature);

}  // namespace host::diagnosis
