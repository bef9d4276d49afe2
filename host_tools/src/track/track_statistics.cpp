#include "track_statistics.h"

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>

namespace host {
namespace {

/// Half of the points belong to tracks of so many images or more: corners
/// of one image, of which there are many, hardly count. `lengths`: sorted.
int length_of_half_the_points(const std::vector<int>& lengths, std::size_t points) {
  std::size_t beyond = 0;
  for (auto length = lengths.rbegin(); length != lengths.rend(); ++length) {
    beyond += static_cast<std::size_t>(*length);
    if (2 * beyond >= points) return *length;
  }
  return 0;
}

}  // namespace

nlohmann::json track_statistics(const std::vector<Frame>& frames) {
  std::map<std::uint32_t, int> length;
  std::size_t points = 0;
  for (const Frame& frame : frames) {
    points += frame.points.size();
    for (const TrackPoint& point : frame.points) ++length[point.track_id];
  }
  std::vector<int> lengths;
  for (const auto& [id, frames_seen] : length) lengths.push_back(frames_seen);
  std::sort(lengths.begin(), lengths.end());
  return {{"images", frames.size()},
          {"tracks", lengths.size()},
          {"tracks_per_image_mean",
           frames.empty() ? 0.0 : static_cast<double>(points) / static_cast<double>(frames.size())},
          {"track_length_median", lengths.empty() ? 0 : lengths[lengths.size() / 2]},
          {"track_length_of_half_the_points", length_of_half_the_points(lengths, points)}};
}

}  // namespace host
