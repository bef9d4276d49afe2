#include "review/joint_filter.h"

#include <cmath>

#include "formatted.h"
#include "review/take_back.h"

namespace host::review {

std::string against_joint_filter(const CoreResult& filter, const CoreResult& segments) {
  constexpr double kMostSquare = 1.5, kMostSigmas = 3.5;
  double sum = 0, largest = 0;
  int values = 0;
  const CoreParameter* farthest = nullptr;
  for (std::size_t i = 0; i < filter.parameters.size(); ++i) {
    const CoreParameter &a = filter.parameters[i], &b = segments.parameters.at(i);
    if (a.verdict == "fixed" || b.verdict == "fixed") continue;
    const double off = std::abs(a.value - b.value) / std::hypot(a.sigma, b.sigma);
    sum += off * off;
    ++values;
    if (!(off > largest)) continue;
    largest = off;
    farthest = &a;
  }
  if (!farthest || (sum <= kMostSquare * values && largest <= kMostSigmas)) return "";
  return formatted(
      "the filter's calibration is not where its sigmas say: %s is %.1f sigma from the calibration by segments, the "
      "mean square over %d values is %.1f (1 at most where both are right). Replay without --joint-ekf",
      farthest->name.c_str(), largest, values, sum / values);
}

void judge_joint_filter(const std::vector<Recording>& sessions, const ReplayOptions& options, ReplayResult* out) {
  if (out->result.status != "calibrated") return;
  ReplayOptions by_segments = options;
  by_segments.joint_ekf = false;
  by_segments.profile = "host";  // of all segments, as the filter has seen them all
  by_segments.core.segments = segments_kept("host", 64);
  by_segments.keep_core = nullptr;
  by_segments.after_session = nullptr;
  const ReplayResult segments = replay_as_stated(sessions, by_segments);
  if (segments.result.status != "calibrated") {
    const std::string why = segments.cause.empty() ? segments.result.status : segments.cause;
    return take_back("insufficient", "nothing to hold the filter's calibration against: by segments, " + why, out);
  }
  const std::string against = against_joint_filter(out->result, segments.result);
  if (!against.empty()) take_back("failed", against, out);
}

}  // namespace host::review
