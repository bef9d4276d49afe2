// Beyond the catalogue: simple additive terms, searched the same way. One that passes every test of an effect becomes a
// term of the model, and takes the place of an effect of the catalogue that was only its likeness. One that is
// significant, but not the same throughout the recording, gets no name; but then something is left over, and a name
// beside it must explain much more than that (held_out_report.h): a small hysteresis of the gyroscope looks like a lag,
// an accelerometer's error that follows attitude like g-sensitivity, except to these terms.
#pragma once

#include "diagnose/evidence.h"

namespace host::diagnosis {

class Beyond {
 public:
  using Fit = std::function<Problem(const std::vector<bool>& estimated)>;

  /// Works on the selection in place; `terms` and `start` grow by what is added.
  Beyond(Evidence* evidence, std::vector<TermInfo>* terms, std::vector<double>* start, Selection* selection,
         Budget* work, bool has_temperature);
  /// What stays significant is in the selection's leftover.
  void run(const Fit& fit);

 private:
  struct Open {
    TermInfo term;
    double chi2 = 0, log10_p = 0;
  };
  std::vector<Open> scan();
  double share() const;
  std::vector<TermInfo> best_that_hold(const std::vector<Open>& open);
  bool holds(const Problem& problem, const Candidate& candidate) const;
  Problem problem_with(const std::vector<TermInfo>& candidates, bool in_parts);
  Candidate candidate_at(std::size_t i, const TermInfo& term) const;
  std::vector<TermGroup> free_in(const Problem& problem) const;
  void add(const TermInfo& term);
  void drop_superfluous(const Fit& fit);
  void refit(const Fit& fit);
  std::vector<TermGroup> groups_but(std::size_t left_out) const;

  Budget* work_;
  Evidence* evidence_;
  std::vector<TermInfo>* terms_;
  std::vector<double>* start_;
  Selection* selection_;
  std::vector<TermInfo> dictionary_;
};

}  // namespace host::diagnosis
