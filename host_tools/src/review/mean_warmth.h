// The temperature at which a calibration without camera_temperature finds the cameras.
#pragma once

#include "replay/core.h"
#include "review/linearised.h"

namespace host::review {

/// Terms of camera_temperature among the candidates count from the mean temperature of the segments on, where the core
/// counts from 25 degC: a camera that was at 40 degC all the time has been calibrated at 40 degC, and the effect has
/// moved none of its values. Weighted by what the segments tell, which needs no thermometer: the column of a value is
/// warmth times a step of theta, so that the mean is the factor at which the two columns are nearest.
void count_from_mean_warmth(const std::vector<CoreParameter>& parameters,
                            const std::vector<diagnosis::TermInfo>& candidates, diagnosis::Problem* problem);

}  // namespace host::review
