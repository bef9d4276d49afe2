// What a user wants to know of the tracks of a camera: how many at a time, and how long they live.
#pragma once

#include <nlohmann/json.hpp>
#include <vector>

#include "../recording.h"

namespace host {

/// {"images", "tracks", "tracks_per_image_mean", "track_length_median",
/// "track_length_of_half_the_points"}; lengths in images.
nlohmann::json track_statistics(const std::vector<Frame>& frames);

}  // namespace host
