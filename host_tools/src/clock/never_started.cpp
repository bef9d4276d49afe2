#include "clock/never_started.h"

#include "formatted.h"

namespace host {
namespace {

/// A device that turns in place has 0.999 and more with the noise of corners, walks along real paths 0.9 to 0.99.
constexpr double kAlike = 0.95;

}  // namespace

std::string never_started(std::uint32_t frames_used, std::uint32_t restarts, const ClockSearch& clock,
                          double stated_s) {
  if (frames_used > 0 || restarts > 0) return "";
  if (!clock.judged || clock.differs_from(stated_s) || clock.correlation < kAlike) return "";
  return formatted(
      "the odometry never started, although images and gyroscope turn alike (correlation %.3f): the device turns in "
      "place, or moves too little to tell how far anything is; move it by a hand's breadth and more about all axes. If "
      "it did, look at the accelerometer's axes and units, and at the focal length",
      clock.correlation);
}

}  // namespace host
