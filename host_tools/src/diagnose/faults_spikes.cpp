// Single readings that no motion explains: a bit that flipped on the bus, a shock to the sensor's die.
//
// A spike stands alone: it is far from where the two readings before it lead, and the one after it is not. Far is `far_bends` times the root
// mean square of the second differences of readings. A motion that begins with a jump goes on, so that what follows it is far from there
// too; a pulse that ends bends by its own steps.
#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>

#include "diagnose/fault.h"
#include "formatted.h"

namespace host {
namespace {

// Of 164,000 real readings of each sensor at 200 Hz (six flights and walks, a phone) none that stands alone is further than 5.6 times the root mean
// square; every second of them, without a filter: one in 27,000, at impacts (docs/results.md, "Spikes").
constexpr double far_bends = 8;
constexpr double near_share = 0.5;       // of a spike's distance: what follows it is nearer than that to where the readings before lead
constexpr double steeper = 2;            // a spike is further off than so many steps of the line that it is measured from
constexpr double most_bends = 4;         // that one bend counts for in the mean: what is being looked for does not raise its own scale
constexpr int memory = 200;              // readings: a second, in which motion stays alike
constexpr int few_readings = 20;         // from which nothing is known yet
constexpr double least_rate_hz = 100;    // of a slower IMU one period may be a twitch of 30 ms
constexpr double gap_periods = 3;        // after which the readings before tell nothing
constexpr double gyro_range = 35, accel_range = 157;   // rad/s, m/s^2: at full scale the device leaves a sample out by itself
constexpr double many = 0.001;           // share from which they are a cause of what goes wrong, and not a remark

/// One sensor: where its readings lead.
class Line {
 public:
  explicit Line(double noise) : floor_(3 * 6 * noise * noise), mean_(floor_) {}   // three axes; a second difference has six variances

  bool is_spike(const Eigen::Vector3d& r, const Eigen::Vector3d& next) const {
    const double here = bend(r), there = (next - 3 * last_ + 2 * before_).squaredNorm();
    return here > far_bends * far_bends * mean_ && there < near_share * near_share * here && steeper * steeper * (last_ - before_).squaredNorm() < here;
  }
  /// `n`: readings so far. A spike counts as well: what comes often is no accident.
  void learn(const Eigen::Vector3d& r, int n) {
    if (n > 1) mean_ += (std::min(bend(r), most_bends * most_bends * mean_) - mean_) / std::min(n, memory);
    mean_ = std::max(mean_, floor_);
  }
  void follow(const Eigen::Vector3d& r) {
    before_ = last_;
    last_ = r;
  }

 private:
  double bend(const Eigen::Vector3d& r) const { return (r - 2 * last_ + before_).squaredNorm(); }

  Eigen::Vector3d last_ = Eigen::Vector3d::Zero(), before_ = Eigen::Vector3d::Zero();
  double floor_, mean_;   ///< squared
};

Eigen::Vector3d vector_of(const std::array<double, 3>& v) { return {v[0], v[1], v[2]}; }

/// The device takes it.
bool is_taken(const ImuSample& s) {
  const Eigen::Vector3d gyro = vector_of(s.gyro), accel = vector_of(s.accel);
  return gyro.allFinite() && accel.allFinite() && gyro.cwiseAbs().maxCoeff() < gyro_range && accel.cwiseAbs().maxCoeff() < accel_range;
}

/// Spikes among samples [begin, end) of `at`, which have no gaps, into `out`.
void find_spikes(const std::vector<ImuSample>& samples, const std::vector<std::size_t>& at, std::size_t begin, std::size_t end, const ImuNoise& noise,
                 std::vector<std::size_t>* out) {
  const double root_rate = std::sqrt(noise.rate_hz);
  Line gyro(noise.gyro_noise_density * root_rate), accel(noise.accel_noise_density * root_rate);
  int n = 0;
  for (std::size_t k = begin; k < end; ++k) {
    const Eigen::Vector3d w = vector_of(samples[at[k]].gyro), a = vector_of(samples[at[k]].accel);
    const bool judged = n > few_readings && k + 1 < end;
    const bool spike = judged && (gyro.is_spike(w, vector_of(samples[at[k + 1]].gyro)) || accel.is_spike(a, vector_of(samples[at[k + 1]].accel)));
    gyro.learn(w, n);
    accel.learn(a, n);
    if (spike) {
      out->push_back(at[k]);
    } else {
      gyro.follow(w);
      accel.follow(a);
      ++n;
    }
  }
}

}  // namespace

std::vector<std::size_t> spikes_of(const Recording& recording) {
  const std::vector<ImuSample>& samples = recording.imu.samples;
  const double rate_hz = recording.imu.noise.rate_hz;
  std::vector<std::size_t> taken, out;
  if (rate_hz < least_rate_hz) return out;
  for (std::size_t i = 0; i < samples.size(); ++i)
    if (is_taken(samples[i])) taken.push_back(i);
  for (std::size_t begin = 0, end; begin < taken.size(); begin = end) {
    for (end = begin + 1; end < taken.size(); ++end)
      if (static_cast<double>(samples[taken[end]].t_ns - samples[taken[end - 1]].t_ns) * 1e-9 > gap_periods / rate_hz) break;
    find_spikes(samples, taken, begin, end, recording.imu.noise, &out);
  }
  return out;
}

std::vector<Fault> spike_faults(const Recording& recording, const std::vector<std::size_t>& spikes) {
  if (spikes.empty()) return {};
  const std::vector<ImuSample>& samples = recording.imu.samples;
  const double share = static_cast<double>(spikes.size()) / static_cast<double>(samples.size());
  return {{"spikes", "imu", samples[spikes.front()].t_ns, samples[spikes.back()].t_ns, spikes.size(), share, many, "-",
           formatted("IMU: %zu of %zu samples stand alone, far from the ones before and after, the first at stamp %lld ns. They are taken for motion: look at the "
                     "sensor's bus, and at what knocks against it, or leave them out of the log.",
                     spikes.size(), samples.size(), static_cast<long long>(samples[spikes.front()].t_ns))}};
}

}  // namespace host
