// What counts as known, as excited, and as a fit of the stated noise. The host's reference and review include it too.
#pragma once

#include "segcal/config.h"

namespace SEGCAL_NS {

/// Thresholds on sigma / prior sigma, and on chi2/dof. Below half the prior's sigma three quarters
/// of what is known come from the data: from there on a direction counts as excited. Residuals
/// below the stated noise do no harm, since sigmas never count on less than what is stated: a good
/// tracker has 0.1 px where 0.5 px are stated, and 0.05 px on rendered images. A twentieth of the
/// stated noise is no noise of a sensor any more: repeated images, or units that are wrong.
template <class S>
struct ReleaseRules {
  S observed = S(0.3), weak = S(0.5);
  S least_chi2_per_dof = S(0.0025), most_chi2_per_dof = S(6);
};

}  // namespace SEGCAL_NS
