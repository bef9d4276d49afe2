#include "diagnose/accel_axes.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "diagnose/axis_orders.h"
#include "formatted.h"
#include "quantile.h"

namespace host {
namespace {

// Share of gravity that is lost as it is. Right axes lose less than 0.0015 in all
// scenarios, in euroc_mh01 and along five real recordings of drones and hands;
// wrong ones 0.008 to 0.06 in calm use (arvr, nav), 0.4 where the device is shaken.
constexpr double gravity_lost = 0.006;
constexpr double gravity_found = 0.05;  // how far from g the mean may be with the axes that are better
// rad/s: how far the gyroscope's bias may be from what the images say of it, and how finely it is looked for.
constexpr double farthest_bias = 0.1, bias_step = 0.005;

/// Windows of eight seconds, every four. The velocity changes little meanwhile, so that the mean of the specific force
/// is gravity, if each sample is turned by the gyroscope into the window's first attitude.
class GravityWindows {
 public:
  GravityWindows(const Recording& recording, const GyroPath& gyro, const Eigen::Matrix3d& M) : gyro_(gyro), M_(M) {
    const std::vector<ImuSample>& samples = recording.imu.samples;
    for (std::size_t k = 0; k + block <= samples.size(); k += block) {
      Eigen::Vector3d f = Eigen::Vector3d::Zero();
      for (std::size_t i = k; i < k + block; ++i)
        f += Eigen::Vector3d(samples[i].accel[0], samples[i].accel[1], samples[i].accel[2]) / block;
      if (!f.allFinite()) f = force_.empty() ? Eigen::Vector3d(Eigen::Vector3d::Zero()) : force_.back();
      force_.push_back(f);
      t_.push_back(static_cast<double>(samples[k + block / 2].t_ns - samples.front().t_ns) * 1e-9);
    }
    n_ = static_cast<std::size_t>(8 * recording.imu.noise.rate_hz) / block;
  }

  /// Windows half over each other must move on: some 2.5 samples a second at the least.
  bool enough() const { return n_ >= 2 && force_.size() >= 2 * n_; }

  /// The means' lengths over g, window by window, if the accelerometer's axes are P times what they are said to be: 1,
  /// if P and bias are right.
  std::vector<double> means(const Eigen::Matrix3d& P, const Eigen::Vector3d& bias) const {
    std::vector<double> out;
    for (std::size_t begin = 0; begin + n_ <= force_.size(); begin += n_ / 2) {
      Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
      Eigen::Vector3d sum = P * force_[begin];
      for (std::size_t k = begin + 1; k < begin + n_; ++k) {
        R = R * gyro_.reordered_rotation(t_[k - 1], t_[k], bias, M_);
        sum += R * (P * force_[k]);
      }
      out.push_back(sum.norm() / static_cast<double>(n_) / 9.80665);
    }
    return out;
  }

  /// The bias within `farthest_bias` of `start` that leaves most of gravity to the axes as they are, by steps along one
  /// axis at a time.
  Eigen::Vector3d best_bias(const Eigen::Vector3d& start) const {
    const Eigen::Matrix3d as_is = Eigen::Matrix3d::Identity();
    Eigen::Vector3d best = start;
    double most = quantile(means(as_is, best), 0.5);
    for (double step = farthest_bias / 2; step >= bias_step;) {
      bool moved = false;
      for (int i = 0; i < 6; ++i) {
        Eigen::Vector3d bias = best;
        bias[i / 2] += i % 2 ? step : -step;
        if (std::abs(bias[i / 2] - start[i / 2]) > farthest_bias) continue;
        const double found = quantile(means(as_is, bias), 0.5);
        if (!(found > most)) continue;  // nor is what is not a number
        most = found;
        best = bias;
        moved = true;
      }
      if (!moved) step /= 2;
    }
    return best;
  }

 private:
  static constexpr std::size_t block = 10;  // samples
  const GyroPath& gyro_;
  Eigen::Matrix3d M_;
  std::vector<Eigen::Vector3d> force_;
  std::vector<double> t_;
  std::size_t n_ = 0;
};

}  // namespace

/// Wrong axes turn gravity about and shorten its mean; the sign of all three cannot be told this way. So does a wrong
/// bias, by 0.9 % where it is 0.1 rad/s: that is looked for first. Against the longest mean, window by window, so that
/// scale errors and changes of velocity drop out.
void accel_axes_fault(const Recording& recording, const GyroPath& gyro, const Eigen::Vector3d& bias,
                      const Eigen::Matrix3d& M, std::vector<Fault>* out) {
  const GravityWindows windows(recording, gyro, M);
  if (!windows.enough()) return;
  const std::vector<AxisOrder>& orders = axis_orders();
  std::vector<std::vector<double>> means;
  for (const AxisOrder& order : orders) means.push_back(windows.means(order.P, bias));
  std::size_t best = 0;
  for (std::size_t j = 0; j < means.size(); ++j)
    if (quantile(means[j], 0.5) > quantile(means[best], 0.5)) best = j;
  const auto lost = [&](const std::vector<double>& as_is) {
    std::vector<double> shares;
    for (std::size_t k = 0; k < as_is.size(); ++k) shares.push_back(1 - as_is[k] / means[best][k]);
    return quantile(shares, 0.5);
  };
  if (lost(means[0]) < gravity_lost || std::abs(quantile(means[best], 0.5) - 1) > gravity_found) return;
  const double share = lost(windows.means(orders[0].P, windows.best_bias(bias)));
  if (share < gravity_lost) return;
  Fault fault;
  fault.kind = "axes";
  fault.sensor = "accel";
  fault.first_ns = recording.imu.samples.front().t_ns;
  fault.last_ns = recording.imu.samples.back().t_ns;
  fault.count = recording.imu.samples.size();
  fault.value = share;
  fault.limit = gravity_lost;
  fault.unit = "-";
  fault.words = formatted("accelerometer: turned by the gyroscope it loses %.1f %% of gravity, ", 100 * share) +
                "which it does not when its axes are read as " + orders[best].name +
                " (or as that with all signs changed). Correct the axes in the driver.";
  out->push_back(fault);
}

}  // namespace host
