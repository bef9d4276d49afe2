// What corners are weighed by, and the second replay by what their tracks show.
#include <algorithm>
#include <cmath>

#include "replay/replay.h"

namespace host {
namespace {

/// What was refused with the noise of use stays refused: by the noise that residuals show, all residuals are as
/// expected.
bool asks_again(CornerNoise noise, const ReplayResult& first) {
  const TrackNoise& found = first.track_noise;
  if (noise == CornerNoise::stated || found.points == 0) return false;
  if (noise == CornerNoise::estimated || is_clearly_less(found, first.model)) return true;
  return first.result.status == "calibrated" && differs(found, first.model);
}

/// Suspects of the first replay that the second no longer shows: noise hides what moves the answer little.
void keep_suspects(const ReplayResult& first, ReplayResult* second) {
  std::vector<Suspect>& kept = second->health.suspects;
  for (const Suspect& s : first.health.suspects) {
    const auto same = [&s](const Suspect& other) { return other.name == s.name; };
    if (std::none_of(kept.begin(), kept.end(), same)) kept.push_back(s);
  }
}

}  // namespace

ReplayResult replay(const std::vector<Recording>& sessions, const ReplayOptions& options) {
  ReplayResult first = replay_as_stated(sessions, options);
  if (!asks_again(options.corner_noise, first)) return first;
  const TrackNoise& found = first.track_noise;
  ReplayOptions second = options;
  const bool walks = first.model.weighs_walks;  // else all of it counts as white: what an error is after a second
  second.core.pixel_sigma = walks ? found.white_px : std::hypot(found.white_px, found.walk_px_per_sqrt_s);
  second.core.track_walk = walks ? found.walk_px_per_sqrt_s : 0;
  ReplayResult out = replay_as_stated(sessions, second);
  out.weighed_by_tracks = true;
  keep_suspects(first, &out);
  return out;
}

}  // namespace host
