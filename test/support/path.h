// A path with everything known in closed form: p from sines (with an
// overtone), R = Rz(yaw) Ry(pitch) Rx(roll) with angles from sines.
#pragma once

#include <algorithm>

#include "random.h"
#include "sensors/imu_link.h"

namespace test {

using namespace SEGCAL_NS;

/// a sin(f t + p) + overtone a sin(2.3 f t), or one of its derivatives by time.
struct Wave {
  double a = 0, f = 1, p = 0, overtone = 0;
  double at(double t, int derivative) const {
    const double quarter = derivative * pi<double> / 2, f2 = 2.3 * f;
    return a * std::pow(f, derivative) * std::sin(f * t + p + quarter) +
           overtone * a * std::pow(f2, derivative) * std::sin(f2 * t + quarter);
  }
};

struct Path {
  Wave move[3], turn[3];
  Vec3<double> g{0, 0, -9.80665};
  double rest_s = 0;  ///< it stands still for so long, then sets off within two seconds

  Vec3<double> position(double t, int derivative) const { return along(move, t, derivative); }
  Vec3<double> angles(double t, int derivative) const { return along(turn, t, derivative); }
  Mat3<double> attitude(double t) const {
    const Vec3<double> a = angles(t, 0);
    return so3_exp<double>({0, 0, a.z()}) * so3_exp<double>({0, a.y(), 0}) * so3_exp<double>({a.x(), 0, 0});
  }
  /// Angular rate in I, from the rates of roll, pitch and yaw.
  Vec3<double> rate(double t) const {
    const Vec3<double> a = angles(t, 0), d = angles(t, 1);
    const double sr = std::sin(a.x()), cr = std::cos(a.x()), sp = std::sin(a.y()), cp = std::cos(a.y());
    return {d.x() - sp * d.z(), cr * d.y() + sr * cp * d.z(), -sr * d.y() + cr * cp * d.z()};
  }
  /// Specific force in I.
  Vec3<double> force(double t) const { return attitude(t).transpose() * (position(t, 2) - g); }
  State<double> state(double t) const {
    State<double> x;
    x.R_GI = attitude(t);
    x.p_GI = position(t, 0);
    x.v_GI = position(t, 1);
    return x;
  }

 private:
  /// Derivative 0, 1 or 2 by time of the waves at s(t), the path's own time: ds/dt goes from 0 to 1 as 3 u^2 - 2 u^3.
  Vec3<double> along(const Wave* wave, double t, int derivative) const {
    constexpr double kRamp = 2;  // s
    const double u = std::min(std::max((t - rest_s) / kRamp, 0.0), 1.0);
    const bool moves = rest_s <= 0 || u == 1;
    const double behind = rest_s > 0 ? rest_s + kRamp / 2 : 0;
    const double s = moves ? t - behind : kRamp * u * u * u * (1 - u / 2);
    const double s1 = moves ? 1 : u * u * (3 - 2 * u);
    const double s2 = moves ? 0 : 6 * u * (1 - u) / kRamp;
    const auto at = [&](int n) { return Vec3<double>(wave[0].at(s, n), wave[1].at(s, n), wave[2].at(s, n)); };
    if (derivative == 0) return at(0);
    return derivative == 1 ? Vec3<double>(s1 * at(1)) : Vec3<double>(s1 * s1 * at(2) + s2 * at(1));
  }
};

/// What a device measures on the path (docs/design.md, section 2, without noise).
inline InertialReading<double> measure(const Path& path, const ImuCalibration<double>& imu, const Vec3<double>& b_a,
                                       const Vec3<double>& b_g, double t) {
  return {scale_misalignment(imu.gyro_scale, imu.gyro_misalignment) * path.rate(t) + b_g,
          scale_misalignment(imu.accel_scale, imu.accel_misalignment) * (imu.R_AI * path.force(t)) + b_a};
}

/// Hand-held shaking about half a metre and half a radian wide; `move` and `turn` scale its two parts.
inline Path random_path(Random* random, double move, double turn) {
  Path path;
  for (int i = 0; i < 3; ++i) {
    path.move[i] = {move * random->uniform(0.4, 0.6), random->uniform(2, 5), random->uniform(0, 6), 0.3};
    path.turn[i] = {turn * random->uniform(0.5, 0.7), random->uniform(2, 5), random->uniform(0, 6), 0};
  }
  return path;
}

}  // namespace test
