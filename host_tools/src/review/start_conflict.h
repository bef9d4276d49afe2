// Do the start and the recording contradict each other where neither outweighs the other?
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "replay/replay.h"

namespace host::review {

/// With a start of variance P and a posterior of variance S, the step from the start has the variance P - S (Box,
/// "Sampling and Bayes' inference in scientific modelling and robustness", J. R. Stat. Soc. A 1980). The step in its
/// own sigmas, for each printed value; 0 of what is fixed. `noise_sigmas`: sigmas by stated noise.
Eigen::VectorXd steps_in_their_sigmas(const std::vector<CoreParameter>& parameters,
                                      const std::vector<double>& noise_sigmas);

/// By how much a sigma grows. A weak value is a mean of what the start and what the recording say, and if these are
/// more than three sigmas apart, one of both is wrong and the mean is as uncertain as they are apart (Birge, "The
/// calculation of errors by the method of least squares", Phys. Rev. 1932, of two measurements). 1 elsewhere: the start
/// has less than a tenth of the weight in a value that is observed.
double start_conflict_factor(const CoreParameter& parameter, double step_in_its_sigmas);

/// The note `start_conflict` on the largest of these factors, if any is above 1.
std::optional<Note> note_on_start_conflict(const std::vector<CoreParameter>& parameters,
                                           const std::vector<double>& factors);

}  // namespace host::review
