#include "twin/motion.h"

#include <Eigen/Geometry>
#include <algorithm>

#include "simulate/imu_simulator.h"

namespace host::twin {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr std::int64_t longest_gap_ns = 500'000'000;
constexpr std::int64_t least_step_ns = 4'500'000;  // poses at 200 Hz
constexpr double largest_jump_m = 0.3;  // from one image to the next beyond its way: a filter that began anew
constexpr double shortest_s = 3;
constexpr double knot_s = 0.5;  // s: what the poses say of the way that the samples do not

Matrix3d exponential(const Vector3d& v) {
  return v.norm() > 0 ? Eigen::AngleAxisd(v.norm(), v.normalized()).toRotationMatrix() : Matrix3d(Matrix3d::Identity());
}

Vector3d logarithm(const Matrix3d& R) {
  const Eigen::AngleAxisd a(R);
  return a.angle() * a.axis();
}

Matrix3d attitude_of(const CoreState& x) {
  return Eigen::Quaterniond(x.q_GI_wxyz[0], x.q_GI_wxyz[1], x.q_GI_wxyz[2], x.q_GI_wxyz[3])
      .normalized()
      .toRotationMatrix();
}

/// The longest row of states without a gap or a jump between them.
std::vector<CoreState> longest_row(const std::vector<CoreState>& states) {
  std::size_t first = 0, best = 0, length = 0;
  const auto breaks = [&states](std::size_t i) {
    const CoreState &a = states[i - 1], &b = states[i];
    const double step = 1e-9 * static_cast<double>(b.t_ns - a.t_ns);
    return step <= 0 || b.t_ns - a.t_ns > longest_gap_ns || (b.p_GI - a.p_GI - step * a.v_GI).norm() > largest_jump_m;
  };
  for (std::size_t i = 1; i <= states.size(); ++i) {
    if (i < states.size() && !breaks(i)) continue;
    if (i - first > length) {
      length = i - first;
      best = first;
    }
    first = i;
  }
  const auto begin = states.begin() + static_cast<std::ptrdiff_t>(best);
  return {begin, begin + static_cast<std::ptrdiff_t>(length)};
}

/// Samples in a row of states, corrected; times in s since its first.
class Way {
 public:
  Way(const Recording& session, const ImuCalibration& imu, const std::vector<CoreState>& row) : row_(row) {
    const Matrix3d from_gyro = imu.T_g.inverse(), from_accel = (imu.T_a * imu.R_AI).inverse();
    std::size_t k = 0;
    for (const ImuSample& s : session.imu.samples) {
      if (s.t_ns < row.front().t_ns || s.t_ns > row.back().t_ns) continue;
      if (!t_.empty() && seconds(s.t_ns) <= t_.back()) continue;
      while (k + 1 < row.size() && row[k + 1].t_ns <= s.t_ns) ++k;
      t_.push_back(seconds(s.t_ns));
      w_.push_back(from_gyro * (Vector3d(s.gyro[0], s.gyro[1], s.gyro[2]) - row[k].b_g));
      f_.push_back(from_accel * (Vector3d(s.accel[0], s.accel[1], s.accel[2]) - row[k].b_a));
    }
  }

  sim::PoseSeries poses() {
    turn();
    move();
    sim::PoseSeries out;
    out.first_ns = row_.front().t_ns + std::llround(1e9 * t_.front());
    double last = -1;
    for (std::size_t i = 0; i < t_.size(); ++i) {
      if (t_[i] - last < 1e-9 * static_cast<double>(least_step_ns)) continue;
      last = t_[i];
      out.t.push_back(t_[i] - t_.front());
      out.R_GI.push_back(R_[i]);
      out.p_GI.push_back(p_[i]);
    }
    return out;
  }
  bool long_enough() const { return t_.size() > 2 && t_.back() - t_.front() > shortest_s; }

 private:
  double seconds(std::int64_t t_ns) const { return 1e-9 * static_cast<double>(t_ns - row_.front().t_ns); }
  /// The last sample that is not later than a state.
  std::size_t at(const CoreState& x) const {
    const auto after = std::upper_bound(t_.begin(), t_.end(), seconds(x.t_ns));
    return static_cast<std::size_t>(after - t_.begin()) - (after == t_.begin() ? 0 : 1);
  }
  /// What the poses say beyond the samples: smooth over half a second.
  sim::Spline beyond(const std::vector<Vector3d>& what) const {
    std::vector<double> t;
    for (const CoreState& x : row_) t.push_back(seconds(x.t_ns));
    return sim::fit_spline(t, what, knot_s);
  }

  /// Attitude: the gyroscope from the first pose on, turned by what is missing to the later ones.
  void turn() {
    R_.assign(1, attitude_of(row_.front()));
    for (std::size_t i = 1; i < t_.size(); ++i)
      R_.push_back(R_.back() * exponential(0.5 * (t_[i] - t_[i - 1]) * (w_[i] + w_[i - 1])));
    std::vector<Vector3d> missing;
    for (const CoreState& x : row_) {
      const std::size_t i = at(x);
      missing.push_back(
          logarithm((R_[i] * exponential((seconds(x.t_ns) - t_[i]) * w_[i])).transpose() * attitude_of(x)));
    }
    const sim::Spline spline = beyond(missing);
    for (std::size_t i = 0; i < t_.size(); ++i) R_[i] = R_[i] * exponential(spline.evaluate(t_[i], 0));
  }

  /// Place: the accelerometer likewise.
  void move() {
    p_.assign(1, row_.front().p_GI);
    std::vector<Vector3d> v(1, row_.front().v_GI);
    for (std::size_t i = 1; i < t_.size(); ++i) {
      const double dt = t_[i] - t_[i - 1];
      const Vector3d a = 0.5 * (R_[i] * f_[i] + R_[i - 1] * f_[i - 1]) + sim::gravity_G;
      p_.push_back(p_.back() + dt * v.back() + 0.5 * dt * dt * a);
      v.push_back(v.back() + dt * a);
    }
    std::vector<Vector3d> missing;
    for (const CoreState& x : row_) {
      const std::size_t i = at(x);
      missing.push_back(x.p_GI - p_[i] - (seconds(x.t_ns) - t_[i]) * v[i]);
    }
    const sim::Spline spline = beyond(missing);
    for (std::size_t i = 0; i < t_.size(); ++i) p_[i] += spline.evaluate(t_[i], 0);
  }

  const std::vector<CoreState>& row_;
  std::vector<double> t_;
  std::vector<Vector3d> w_, f_, p_;  ///< rad/s and m/s^2 in I; m in G
  std::vector<Matrix3d> R_;
};

}  // namespace

sim::PoseSeries motion_of(const Recording& session, const ReplayResult& fit) {
  std::vector<CoreState> own;
  for (const CoreState& x : fit.trajectory)
    if (!session.imu.samples.empty() && x.t_ns >= session.imu.samples.front().t_ns &&
        x.t_ns <= session.imu.samples.back().t_ns)
      own.push_back(x);
  const std::vector<CoreState> row = longest_row(own);
  if (row.size() < 2) return {};
  Way way(session, fit.calibration.imu, row);
  return way.long_enough() ? way.poses() : sim::PoseSeries{};
}

}  // namespace host::twin
