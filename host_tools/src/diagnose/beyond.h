// Beyond the catalogue: simple additive terms, searched the same way, where the catalogue leaves a gap or where one of them
// says more than what was accepted.
#pragma once

#include "diagnose/evidence.h"

namespace host::diagnosis {

class Beyond {
 public:
  using Fit = std::function<Problem(const std::vector<bool>& estimated)>;

  /// Works on the selection in place; `terms` and `start` grow by what is added.
  Beyond(Evidence* evidence, std::vector<TermInfo>* terms, std::vector<double>* start, Selection* selection, bool has_temperature);
  void run(const Fit& fit);

 private:
  struct Best {
    TermInfo term;
    double log10_p = 0;
    bool found = false;
  };
  Best search();
  bool holds(const Problem& problem, const Candidate& candidate) const;
  Problem problem_with(const std::vector<TermInfo>& candidates, bool halves);
  Candidate candidate_at(std::size_t i, const TermInfo& term) const;
  std::vector<TermGroup> taken() const;
  void add(const TermInfo& term, const Fit& fit);
  void drop_superfluous(const Fit& fit);
  void refit(const Fit& fit);
  std::vector<TermGroup> groups_but(std::size_t left_out) const;

  Evidence* evidence_;
  std::vector<TermInfo>* terms_;
  std::vector<double>* start_;
  Selection* selection_;
  std::vector<TermInfo> dictionary_;
};

}  // namespace host::diagnosis
