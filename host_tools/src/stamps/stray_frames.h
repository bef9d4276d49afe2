// Images whose stamps lie apart: ahead of those that follow them
// in the log, which come back to where the ones before were.
#pragma once

#include "recording.h"

namespace host {

/// Moves such frames of each camera to CameraData::strays. A device that waits for the samples of such an image would
/// let all others go by, and so would a replay. Left where they are: images in the past, which cost themselves alone; a
/// clock that was set back, of the camera for good or of the whole log. Stamps of a device's own log are the device's.
void set_strays_aside(Recording* recording);

}  // namespace host
