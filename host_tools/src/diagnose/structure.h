// Is there structure in the residuals, and what does it follow?
//
// Each list of residuals is held against each cause in two ways: rank correlation, which sees what grows or falls with
// the cause, and the variance between eight bins of equal size, which sees any other shape. Both are compared with what
// noise gives, over the number of tests; residuals that follow each other and are alike count for fewer than they are.
#pragma once

#include "diagnose/residuals.h"

namespace host::diagnosis {

struct Structure {
  std::string sensor, axis, against, unit;
  double correlation = 0;  ///< rank correlation; of the bins where those say more: the share of the spread, unsigned
  double log10_p = 0;      ///< corrected for the number of tests
  std::vector<double> bin_cause, bin_mean, bin_sigma;  ///< for the report: cause, mean residual and its sigma
};

/// The significant ones (log10 p below `level`), most significant first; per sensor and axis at most `most`.
std::vector<Structure> find_structure(const std::vector<ResidualList>& lists, double level, int most);

/// Mean product of neighbours in a series over the mean square: 0 for white noise.
double lag_one_autocorrelation(const ResidualList& list);

}  // namespace host::diagnosis
