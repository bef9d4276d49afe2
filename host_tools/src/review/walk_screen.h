// Before the biases' walk is tested link by link, which takes a quarter of a replay: can a step be there at all?
#pragma once

#include "reference/problem.h"

namespace host::review {

/// From the biases of neighbouring states alone. Were attitude and place known, a bias would be measured with the
/// sensor's white noise by all that came before it and by all that comes after; what is known in truth is less, so that
/// this smoother's z is a lower bound of the test's.
bool may_step(const reference::Problem& problem);

}  // namespace host::review
