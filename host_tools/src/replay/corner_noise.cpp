// What corners are weighed by, and the second replay by what their tracks show.
#include <cmath>

#include "replay/replay.h"
#include "review/take_back.h"
#include "review/unseen_effects.h"

namespace host {

bool asks_again(CornerNoise noise, const ReplayResult& first) {
  const TrackNoise& found = first.track_noise;
  if (noise == CornerNoise::stated || found.points == 0) return false;
  const std::string& status = first.result.status;
  if (noise == CornerNoise::estimated || (is_clearly_less(found, first.model) && status != "failed")) return true;
  return status == "calibrated" && differs(found, first.model);
}

ReplayResult replay(const std::vector<Recording>& sessions, const ReplayOptions& options) {
  ReplayResult first = replay_as_stated(sessions, options);
  if (!asks_again(options.corner_noise, first)) return first;
  const TrackNoise found = to_weigh_by(first.track_noise);
  ReplayOptions second = options;
  const bool walks = first.model.weighs_walks;  // else all of it counts as white: what an error is after a second
  second.core.pixel_sigma = walks ? found.white_px : std::hypot(found.white_px, found.walk_px_per_sqrt_s);
  second.core.track_walk = walks ? found.walk_px_per_sqrt_s : 0;
  ReplayResult out = replay_as_stated(sessions, second);
  out.weighed_by_tracks = true;
  review::keep_suspects(first, &out);
  review::note_unseen_effects(&out);
  return out;
}

}  // namespace host
