// Stamps of images that follow the exposure: taken where it begins or ends, and not in its middle.
#pragma once

#include "recording.h"

namespace host {

/// Do most of its images have an exposure?
bool has_exposures(const Recording& recording);

/// t += k exposure, for every image of the rig. One whose exposure nobody says has that of the image nearest in time,
/// as exposure control does not jump; it is written into the frame.
void move_by_exposure(double k, Recording* recording);

/// The same for a command that was asked to. Returns a sentence on what was done. Throws InputError that says what to
/// do, without exposures or where stamps would not stay in order.
std::string add_exposure_to_stamps(double k, Recording* recording);

}  // namespace host
