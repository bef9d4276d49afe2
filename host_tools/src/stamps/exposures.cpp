#include "stamps/exposures.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "formatted.h"

namespace host {
namespace {

constexpr double most_without = 0.5;  // of the images: with more, the exposures are those of another recording

/// Exposures by moment: cameras of one rig share their trigger, and their images have to stay together.
std::map<std::int64_t, double> known_exposures(const Recording& recording) {
  std::map<std::int64_t, double> out;
  for (const CameraData& camera : recording.cameras)
    for (const Frame& frame : camera.frames)
      if (frame.exposure_s > 0) out[frame.t_ns] = frame.exposure_s;
  return out;
}

double nearest_exposure(const std::map<std::int64_t, double>& known, std::int64_t t_ns) {
  const auto after = known.lower_bound(t_ns);
  if (after == known.end()) return std::prev(after)->second;
  if (after == known.begin() || after->first - t_ns < t_ns - std::prev(after)->first) return after->second;
  return std::prev(after)->second;
}

std::size_t count_without(const Recording& recording) {
  std::size_t out = 0;
  for (const Frame& frame : recording.cameras.front().frames) out += frame.exposure_s > 0 ? 0 : 1;
  return out;
}

/// The first stamp that is not after the one before it, of those that were in the stamps `before`; 0: none.
std::int64_t first_out_of_order(const std::vector<Frame>& before, const std::vector<Frame>& after) {
  for (std::size_t i = 1; i < after.size(); ++i) {
    if (before[i].t_ns > before[i - 1].t_ns && after[i].t_ns <= after[i - 1].t_ns) return before[i].t_ns;
  }
  return 0;
}

}  // namespace

bool has_exposures(const Recording& recording) {
  if (recording.cameras.empty() || recording.cameras.front().frames.empty()) return false;
  const auto without = static_cast<double>(count_without(recording));
  return without <= most_without * static_cast<double>(recording.cameras.front().frames.size());
}

void move_by_exposure(double k, Recording* recording) {
  const std::map<std::int64_t, double> known = known_exposures(*recording);
  if (known.empty()) return;
  for (CameraData& camera : recording->cameras) {
    for (Frame& frame : camera.frames) {
      if (!(frame.exposure_s > 0)) frame.exposure_s = nearest_exposure(known, frame.t_ns);
      frame.t_ns += std::llround(1e9 * k * frame.exposure_s);
    }
  }
}

std::string add_exposure_to_stamps(double k, Recording* recording) {
  const std::string where = recording->root.string();
  if (!has_exposures(*recording))
    throw InputError(where +
                     "/mav0/cam0/exposure.csv: expected the exposure of most images for --stamp-exposure; write "
                     "'timestamp [ns],exposure [ns]' there, or leave the option away");
  const std::vector<CameraData> before = recording->cameras;
  const std::size_t without = count_without(*recording), images = before.front().frames.size();
  move_by_exposure(k, recording);
  double least = recording->cameras.front().frames.front().exposure_s, longest = least;
  for (std::size_t c = 0; c < before.size(); ++c) {
    const std::vector<Frame>& frames = recording->cameras[c].frames;
    if (const std::int64_t at = first_out_of_order(before[c].frames, frames))
      throw InputError(where + ": --stamp-exposure: expected stamps that stay in order, but the image of " +
                       std::to_string(at) + " would come before the one ahead of it; check the unit in exposure.csv");
    for (const Frame& f : frames) {
      least = std::min(least, f.exposure_s);
      longest = std::max(longest, f.exposure_s);
    }
  }
  std::string out = formatted("%g times the exposure, ", k) + formatted("%.3g", 1e3 * least) +
                    formatted(" to %.3g ms, was added to the stamps of ", 1e3 * longest) + std::to_string(images) +
                    " images";
  if (without > 0) out += "; of " + std::to_string(without) + " nobody says it: it was taken from their neighbours";
  return out;
}

}  // namespace host
