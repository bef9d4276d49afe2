// How two clocks are compared by rotation, and when the answer is believed: one place for the device's search and for
// the host's (host_tools/src/clock, host_tools/src/diagnose/image_rotation.cpp).
#pragma once

#include "segcal/config.h"

namespace SEGCAL_NS {
namespace clock_criteria {

// Offsets that are tried.
constexpr double kReach_s = 0.5;
constexpr double kStep_s = 0.005;     ///< rotation up to 20 Hz does not hide in it
constexpr int kStepsEitherWay = 100;  ///< kReach_s / kStep_s
constexpr int kOffsets = 2 * kStepsEitherWay + 1;

// Pairs of images. Nearer ones have more noise than rotation, in farther ones the rate changes.
constexpr double kShortest_s = 0.04, kLongest_s = 0.25;
constexpr int kLeastRays = 12;
constexpr double kTolerated = 0.01;  ///< rad, above this a ray counts less: parallax and wrong matches
constexpr int kLeastPairs = 30;

constexpr double kLeastTurning = 0.1;  ///< rad/s rms: below it parallax looks the same
// Parallax and a start that is a few degrees and per cent off leave 0.85 and more (simulated arvr, nav, rich; a phone
// carried through a flat 0.9; euroc_mh01 0.97).
constexpr double kLeastCorrelation = 0.75;
constexpr double kLobe_s = 0.1;          ///< other peaks are looked for beyond this
constexpr double kPeakStandsOut = 0.85;  ///< what the peak leaves unexplained, over the same of the best one elsewhere

// Only on a device, which does not have the whole recording.
constexpr double kWindow_s = 2;
constexpr int kLeastPairsOfWindow = 4;
constexpr int kLeastWindows = 6;
constexpr double kPatience_s = 10;  ///< of stream before something is said to be missing
constexpr double kCommon_s = 0.002;
constexpr double kMostSigma_s = 0.004;

}  // namespace clock_criteria
}  // namespace SEGCAL_NS
