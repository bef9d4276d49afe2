// How noisy a recording's corner tracks are: white noise and a random walk along each track, by maximum likelihood from
// the residuals of a calibration.
#pragma once

#include <vector>

#include "replay/core.h"

namespace host {

/// Per image axis.
struct TrackNoise {
  double white_px = 0, walk_px_per_sqrt_s = 0;
  int points = 0;  ///< image points it was found from; 0: nothing was
};

/// Restricted maximum likelihood (Patterson and Thompson, Biometrika 1971): each landmark's place is unknown, its
/// residuals count as far as it does not take them up; poses and `calibration` count as known. Outliers and slips weigh
/// as they do in the calibration (lib/src/segments/track_noise.h), by the noise that is being found.
TrackNoise estimate_track_noise(const std::vector<CoreKept>& kept, const Calibration& calibration,
                                const CoreModel& model);

/// What to weigh corners by: the walk is at least such that an error after a second is 0.1 px. On rendered images,
/// whose truth is known, corners are 0.2 px off after four seconds where residuals show 0.03 px/sqrt(s): poses and
/// landmarks take up what corners have in common.
TrackNoise to_weigh_by(const TrackNoise& shown);

/// Of an error after a second, a fifth less than stated: sigmas would be a quarter too large.
bool is_clearly_less(const TrackNoise& noise, const CoreModel& stated);
/// In one of the two by a fifth of what an error after a second is stated to be; without walks in the model in that
/// error.
bool differs(const TrackNoise& noise, const CoreModel& stated);

}  // namespace host
