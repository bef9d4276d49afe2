#include "gravity.h"

#include <cmath>

#include "angles.h"

namespace host {

double normal_gravity(double latitude_deg, double height_m) {
  constexpr double at_equator = 9.7803253359, k = 0.00193185265241, e2 = 0.00669437999013;  // TR8350.2, table 3.4
  constexpr double a = 6378137, f = 1 / 298.257223563, m = 0.00344978650684;
  const double s = std::sin(latitude_deg * rad_per_deg), s2 = s * s, h = height_m / a;
  const double at_sea_level = at_equator * (1 + k * s2) / std::sqrt(1 - e2 * s2);
  return at_sea_level * (1 - 2 * (1 + f + m - 2 * f * s2) * h + 3 * h * h);
}

}  // namespace host
