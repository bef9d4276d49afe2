// Circles and degrees.
#pragma once

namespace host {

inline constexpr double pi = 3.14159265358979323846;
inline constexpr double two_pi = 2 * pi;
inline constexpr double rad_per_deg = pi / 180;
inline constexpr double deg_per_rad = 180 / pi;

}  // namespace host
