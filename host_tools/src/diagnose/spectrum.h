// Power of a signal in bands of frequency, window by window.
#pragma once

#include <vector>

namespace host {

/// Frequencies as shares of the sampling rate.
struct Band {
  double from, to;
};

constexpr Band noise_band{0.2, 0.45};  // 40 to 90 Hz at 200 Hz
constexpr Band lower_noise_band{0.2, 0.325}, upper_noise_band{0.325, 0.45};
constexpr Band motion_band{0.04, 0.15};  // 8 to 30 Hz at 200 Hz: shaking; slow motion has no part in either

/// Windows of 128 samples, half of each shared with the next, tapered by Blackman and Harris (side lobes of -92 dB:
/// hand motion of 1 rad/s stays 30 dB below noise of 2e-3 rad/s). Of each window the median over the band's bins,
/// scaled so that white noise of density N gives N^2: narrow lines, from a rotor, do not count.
std::vector<double> band_levels(const std::vector<double>& signal, double rate_hz, const Band& band);

}  // namespace host
