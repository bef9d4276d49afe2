// Whether the odometry followed the images and the segments their own IMU samples: where not, a fit says little.
#pragma once

#include <string>
#include <vector>

#include "replay/replay.h"

namespace host::review {

/// The odometry used half of the images that it was offered.
bool odometry_stayed(const Health& health);
std::string used_words(const Health& health);

/// Segments that do not follow their own IMU samples are never kept; where a device changes
/// on the way and the odometry does not, those since then are such, and what is left agrees
/// on what the device was before. `all`: every segment that was scored, in order.
bool segments_followed(const std::vector<CoreSegment>& all);
std::string followed_words(const std::vector<CoreSegment>& all);

/// Segments so far apart that no one calibration fits them.
std::string scatter_words(const Health& health);

}  // namespace host::review
