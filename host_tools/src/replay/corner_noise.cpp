// What corners are weighed by, and the second replay where that is what their tracks show.
#include <cmath>

#include "replay/replay.h"

namespace host {

ReplayResult replay(const std::vector<Recording>& sessions, const ReplayOptions& options) {
  ReplayResult first = replay_as_stated(sessions, options);
  const TrackNoise& found = first.track_noise;
  if (options.corner_noise == CornerNoise::stated || found.points == 0) return first;
  if (options.corner_noise == CornerNoise::less_than_stated && !is_clearly_less(found, first.model)) return first;
  ReplayOptions second = options;
  const bool walks = first.model.weighs_walks;  // else all of it counts as white: what an error is after a second
  second.core.pixel_sigma = walks ? found.white_px : std::hypot(found.white_px, found.walk_px_per_sqrt_s);
  second.core.track_walk = walks ? found.walk_px_per_sqrt_s : 0;
  ReplayResult out = replay_as_stated(sessions, second);
  out.weighed_by_tracks = true;
  return out;
}

}  // namespace host
