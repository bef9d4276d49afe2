// The model that a diagnosis searches for: its terms, who owns them, and the values that the next fit begins at.
#pragma once

#include "diagnose/model_terms.h"
#include "diagnose/told.h"

namespace host::diagnosis {

/// Effects and terms are the search's business; `has_temperature`: all recordings have one.
CoreOptions without_effects(CoreOptions core, bool has_temperature);

struct SearchedModel {
  /// The catalogue's terms, and the effects and terms of `given`: those
  /// are estimated in every fit but the first, from their values.
  SearchedModel(const CoreOptions& given, bool has_temperature, bool has_exposures);

  std::vector<TermInfo> terms;  ///< columns of the fits
  std::vector<double> start;    ///< of each term, where the next fit begins
  std::vector<Candidate> candidates;
  std::vector<int> known;   ///< candidates that were given: in every model but the first
  std::vector<int> needed;  ///< of these, what is in the first as well

  /// Counts effects of the catalogue as known.
  void include(const Told& told);
  /// Terms that a search has put behind the others.
  void forget_additions();
  /// The next fit begins at what the rows of the last one say
  /// about these candidates: its odometry knows the effects then.
  void begin_at(const Problem& last, const std::vector<int>& accepted);
  /// Of each term: does one of these candidates own it?
  std::vector<bool> columns_of(const std::vector<int>& accepted) const;
  /// Was a term on the image accepted that the catalogue has not? Polynomials come near a lens that has no name here;
  /// what is left looks like noise.
  bool lens_has_no_name(const Selection& selection) const;

 private:
  void begin_with(const CoreOptions& given);
  std::size_t given_terms_ = 0;
};

}  // namespace host::diagnosis
