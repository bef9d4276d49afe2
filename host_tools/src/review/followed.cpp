#include "review/followed.h"

#include <algorithm>
#include <cmath>

#include "formatted.h"

namespace host::review {
namespace {

constexpr double kLeastUsed = 0.5;                         // of the images that the odometry was offered
constexpr double kMostUnsettled = 0.5, kFewUnsettled = 3;  // of the newer half of the segments; fewer are no sign

/// How many segments are the newer half of the last session: until the first calibration many may not follow.
std::size_t newer(const std::vector<CoreSegment>& all) {
  const auto of_last =
      std::count_if(all.begin(), all.end(), [&all](const CoreSegment& s) { return s.session == all.back().session; });
  return static_cast<std::size_t>(of_last) / 2;
}

std::size_t unsettled(const std::vector<CoreSegment>& all) {
  return static_cast<std::size_t>(std::count_if(all.end() - static_cast<std::ptrdiff_t>(newer(all)), all.end(),
                                                [](const CoreSegment& s) { return !s.settled; }));
}

}  // namespace

bool odometry_stayed(const Health& health) { return health.frames_used >= kLeastUsed * health.frames_offered; }

std::string used_words(const Health& health) {
  return formatted("odometry used %u of %u images that it was offered (%u restarts)", health.frames_used,
                   health.frames_offered, health.filter_restarts);
}

std::string scatter_words(const Health& health) {
  return formatted(
      "the segments disagree with each other by %.1f times their noise, so that no one calibration fits them: the "
      "device changed on the way (calibrate what was before and after by themselves), or an effect is missing (segcal "
      "diagnose)",
      std::sqrt(health.segment_scatter));
}

bool segments_followed(const std::vector<CoreSegment>& all) {
  const auto lost = static_cast<double>(unsettled(all));
  return lost < kFewUnsettled || lost <= kMostUnsettled * static_cast<double>(newer(all));
}

std::string followed_words(const std::vector<CoreSegment>& all) {
  return formatted(
      "%zu of the last %zu segments do not follow their own IMU samples with what the odometry believed: "
      "a start that is far off, or a device that changed on the way (a camera that moved); "
      "calibrate what was before and after by themselves",
      unsettled(all), newer(all));
}

}  // namespace host::review
