// The size of gravity at a place.
#pragma once

namespace host {

constexpr double kStandardGravity = 9.80665;  ///< m/s^2, what is taken where nothing is stated

/// Normal gravity of the WGS 84 ellipsoid, m/s^2: Somigliana's closed formula at sea level,
/// second order in height (NIMA TR8350.2, third edition, equations 4-1 and 4-3). Local
/// anomalies are left out: below 0.001 m/s^2 in most places, up to 0.002 to 0.004 in
/// mountains. Geodetic latitude -90 to 90 deg, height above the ellipsoid -1000 to 20,000 m.
double normal_gravity(double latitude_deg, double height_m);

}  // namespace host
