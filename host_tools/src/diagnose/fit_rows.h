// What the core hands out at a fit, in the form that rows are asked in.
#pragma once

#include "diagnose/selection.h"
#include "replay/core.h"

namespace host::diagnosis {

/// The triangle over [theta | candidates | rhs], square.
Eigen::MatrixXd unpacked(const CoreRows& rows);
/// Steps of these blocks are looked for; sizes of a shock.
std::vector<Block> blocks_of(const Calibration& calibration);
/// Of the first n parameters, about the values that were found.
Prior prior_of(const CoreResult& result, int n);
/// Terms from their places among [taken | asked] to the caller's order.
void reorder(const std::vector<int>& place, Rows* rows, int n_theta);
void reorder(const std::vector<int>& place, Problem* problem);

}  // namespace host::diagnosis
