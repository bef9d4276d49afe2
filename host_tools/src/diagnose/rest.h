// Where a device rests, and what its IMU says there: the Allan deviation.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "diagnose/imu_noise.h"

namespace host {

/// Samples [begin, end).
struct Span {
  std::size_t begin = 0, end = 0;
};

/// IMU samples between the first and the last frame of any camera; all where there are no frames.
std::vector<ImuSample> samples_with_frames(const Recording& recording);

/// 1 / median interval; 0 for fewer than 3 samples.
double median_rate_hz(const std::vector<ImuSample>& samples);

/// The longest stretch over which means of half a second keep within 0.003 rad/s and 0.03 m/s^2: above noise, three
/// times the stated one too, and far below what a hand does.
Span longest_rest(const std::array<std::vector<double>, 6>& axes, double rate_hz);

/// Overlapping Allan deviation of three axes over a span, at a dozen averaging times up to a ninth of it.
std::vector<AllanPoint> allan_deviation(const std::vector<double>* axes, const Span& span, double rate_hz);

/// White noise has deviation = density / sqrt(tau): the median of
/// deviation sqrt(tau) over averaging times in the range; 0 if none.
double white_density(const std::vector<AllanPoint>& points, std::size_t axis, double from_s, double to_s);

}  // namespace host
