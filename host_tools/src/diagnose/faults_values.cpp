// Values of samples: stuck at an extreme, repeated, not a number.
// Those that stand alone are looked at first (faults_spikes.cpp).
#include <algorithm>
#include <array>
#include <cmath>

#include "diagnose/fault.h"
#include "diagnose/spectrum.h"
#include "formatted.h"

namespace host {
namespace {

constexpr std::size_t least_stuck = 8;  // samples at one extreme
// Near its largest value a signal thins out: the last thousandth of its range holds
// fewer samples than the one before, and so does the last digit of one that is coarser.
// A pile at exactly one value, three times what lies just below, a limit made.
constexpr double pile_ratio = 3;
constexpr double pile_width = 0.001;       // of the range
constexpr double pile_digits = 5.5;        // last digits
constexpr double least_frozen_s = 0.1;     // all three axes to the last bit
constexpr double least_axis_frozen_s = 1;  // one axis while the others go on
constexpr double most_repeats = 0.05;      // share of samples that repeat the one before

using Values = std::array<double, 3> ImuSample::*;

struct Sensor {
  const char* name;
  const char* word;
  Values values;
  const char* unit;
};

constexpr Sensor sensors[] = {{"gyro", "gyroscope", &ImuSample::gyro, "rad/s"},
                              {"accel", "accelerometer", &ImuSample::accel, "m/s^2"}};

void check_finite(const std::vector<ImuSample>& samples, const Sensor& sensor, std::vector<Fault>& out) {
  Fault fault{"not_finite", sensor.name, 0, 0, 0, 0, 0, "-", ""};
  for (const ImuSample& s : samples) {
    const auto& v = s.*sensor.values;
    if (std::isfinite(v[0]) && std::isfinite(v[1]) && std::isfinite(v[2])) continue;
    if (!fault.count++) fault.first_ns = s.t_ns;
    fault.last_ns = s.t_ns;
  }
  fault.value = static_cast<double>(fault.count) / static_cast<double>(samples.size());
  if (fault.value <= 0.001) return;  // single ones are skipped by the core
  fault.words =
      std::string(sensor.word) + formatted(": %.0f samples are not a number. Look at the driver's error handling.",
                                           static_cast<double>(fault.count));
  out.push_back(fault);
}

/// The smallest step between neighbouring values: the sensor's last digit, or nearly nothing.
double quantum_of(const std::vector<double>& sorted) {
  double smallest = sorted.back() - sorted.front();
  for (std::size_t k = 1; k < sorted.size(); ++k)
    if (sorted[k] > sorted[k - 1]) smallest = std::min(smallest, sorted[k] - sorted[k - 1]);
  return smallest;
}

/// Samples at the largest value of an axis times `sign`, if they pile up there; 0 otherwise.
std::size_t pile_at_top(const std::vector<ImuSample>& samples, const Sensor& sensor, std::size_t axis, double sign,
                        double* top) {
  std::vector<double> sorted;
  for (const ImuSample& s : samples)
    if (std::isfinite((s.*sensor.values)[axis])) sorted.push_back(sign * (s.*sensor.values)[axis]);
  if (sorted.size() < 100) return 0;
  std::sort(sorted.begin(), sorted.end());
  const double range = sorted.back() - sorted.front();
  *top = sorted.back() - 1e-6 * range;
  if (!(range > 0)) return 0;
  const double below = sorted.back() - std::max(pile_width * range, pile_digits * quantum_of(sorted));
  std::size_t at_top = 0, near = 0;
  for (auto v = sorted.rbegin(); v != sorted.rend() && *v >= below; ++v) ++(*v >= *top ? at_top : near);
  return at_top >= least_stuck && static_cast<double>(at_top) > pile_ratio * static_cast<double>(near) ? at_top : 0;
}

/// Both extremes of one axis; true if it saturates.
bool check_extremes(const std::vector<ImuSample>& samples, const Sensor& sensor, std::size_t axis,
                    std::vector<Fault>& out) {
  Fault fault{"saturation", std::string(sensor.name) + "." + "xyz"[axis], 0, 0, 0, 0, 0, sensor.unit, ""};
  for (double sign : {1.0, -1.0}) {
    double top = 0;
    if (!pile_at_top(samples, sensor, axis, sign, &top)) continue;
    for (const ImuSample& s : samples) {
      if (!(sign * (s.*sensor.values)[axis] >= top)) continue;
      fault.first_ns = fault.count ? std::min(fault.first_ns, s.t_ns) : s.t_ns;
      fault.last_ns = std::max(fault.last_ns, s.t_ns);
      fault.value = (s.*sensor.values)[axis];
      ++fault.count;
    }
  }
  if (!fault.count) return false;
  fault.limit = static_cast<double>(least_stuck);
  fault.words = std::string(sensor.word) + " " + "xyz"[axis] +
                formatted(": %.0f samples (%.2f %%) stand at the extreme, %.4g ", static_cast<double>(fault.count),
                          100.0 * static_cast<double>(fault.count) / static_cast<double>(samples.size()), fault.value) +
                sensor.unit + ". Set a larger measuring range, or move less.";
  out.push_back(fault);
  return true;
}

bool same(const std::array<double, 3>& a, const std::array<double, 3>& b) { return a == b; }

/// A sample's noise is below its last digit: repeats prove nothing then.
bool is_coarse(const std::vector<ImuSample>& samples, const Sensor& sensor, double sample_sigma) {
  double finest = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    std::vector<double> sorted;
    for (const ImuSample& s : samples)
      if (std::isfinite((s.*sensor.values)[axis])) sorted.push_back((s.*sensor.values)[axis]);
    std::sort(sorted.begin(), sorted.end());
    if (sorted.empty() || sorted.front() == sorted.back()) continue;
    const double quantum = quantum_of(sorted);
    finest = finest > 0 ? std::min(finest, quantum) : quantum;
  }
  return finest > 2 * sample_sigma;
}

void check_frozen(const std::vector<ImuSample>& samples, const Sensor& sensor, double rate_hz,
                  std::vector<Fault>& out) {
  Fault fault{"frozen", sensor.name, 0, 0, 0, 0, least_frozen_s, "s", ""};
  std::size_t run_begin = 0, repeats = 0;
  for (std::size_t k = 1; k <= samples.size(); ++k) {
    if (k < samples.size() && same(samples[k].*sensor.values, samples[k - 1].*sensor.values)) {
      ++repeats;
      continue;
    }
    const double seconds = static_cast<double>(k - run_begin) / rate_hz;
    if (seconds >= least_frozen_s && k - run_begin >= 5) {
      if (!fault.count) fault.first_ns = samples[run_begin].t_ns;
      fault.last_ns = samples[k - 1].t_ns;
      fault.count += k - run_begin;
      fault.value = std::max(fault.value, seconds);
    }
    run_begin = k;
  }
  const double share = static_cast<double>(repeats) / static_cast<double>(samples.size());
  if (fault.count) {
    fault.words = std::string(sensor.word) +
                  formatted(": %.0f samples repeat the same reading, up to %.2f s long. ",
                            static_cast<double>(fault.count), fault.value) +
                  "The sensor or its driver hung: restart it and record again.";
  } else if (share > most_repeats) {
    fault = {"frozen",
             sensor.name,
             samples.front().t_ns,
             samples.back().t_ns,
             repeats,
             share,
             most_repeats,
             "-",
             std::string(sensor.word) + formatted(": %.0f %% of the samples repeat the one before. ", 100 * share) +
                 "It measures at a lower rate than is logged: log each reading once."};
  }
  if (fault.count) out.push_back(fault);
}

/// One axis that keeps its value to the last bit while the others
/// go on: a channel of the sensor or of the driver is dead.
void check_frozen_axis(const std::vector<ImuSample>& samples, const Sensor& sensor, std::size_t axis, double rate_hz,
                       std::vector<Fault>& out) {
  Fault fault{"frozen", std::string(sensor.name) + "." + "xyz"[axis], 0, 0, 0, 0, least_axis_frozen_s, "s", ""};
  std::size_t begin = 0;
  for (std::size_t k = 1; k <= samples.size(); ++k) {
    if (k < samples.size() && (samples[k].*sensor.values)[axis] == (samples[begin].*sensor.values)[axis]) continue;
    const double seconds = static_cast<double>(k - begin) / rate_hz;
    if (seconds >= least_axis_frozen_s) {
      if (!fault.count) fault.first_ns = samples[begin].t_ns;
      fault.last_ns = samples[k - 1].t_ns;
      fault.count += k - begin;
      fault.value = std::max(fault.value, seconds);
    }
    begin = k;
  }
  if (!fault.count) return;
  fault.words = std::string(sensor.word) + " " + "xyz"[axis] +
                formatted(": %.0f samples repeat the same reading, up to %.2f s long, while the other axes go on. ",
                          static_cast<double>(fault.count), fault.value) +
                "This channel is dead: restart the sensor and record again.";
  out.push_back(fault);
}

/// All axes together, or else each alone.
void check_repeats(const std::vector<ImuSample>& samples, const Sensor& sensor, double rate_hz,
                   std::vector<Fault>& out) {
  const std::size_t before = out.size();
  check_frozen(samples, sensor, rate_hz, out);
  for (std::size_t axis = 0; axis < 3 && out.size() == before; ++axis)
    check_frozen_axis(samples, sensor, axis, rate_hz, out);
}

}  // namespace

std::vector<Fault> value_faults(const Recording& recording) {
  const std::vector<std::size_t> spikes = spikes_of(recording);
  std::vector<Fault> out = spike_faults(recording, spikes);
  std::vector<ImuSample> samples;  // without spikes: several of one height are no limit of the range
  std::size_t next = 0;
  for (std::size_t i = 0; i < recording.imu.samples.size(); ++i) {
    if (next < spikes.size() && spikes[next] == i) {
      ++next;
    } else {
      samples.push_back(recording.imu.samples[i]);
    }
  }
  const ImuNoise& noise = recording.imu.noise;
  if (samples.size() < 100) return out;
  for (const Sensor& sensor : sensors) {
    check_finite(samples, sensor, out);
    bool saturates = false;
    for (std::size_t axis = 0; axis < 3; ++axis) saturates = check_extremes(samples, sensor, axis, out) || saturates;
    const double density = sensor.values == &ImuSample::gyro ? noise.gyro_noise_density : noise.accel_noise_density;
    // Three axes at their extremes repeat as well, and have been reported.
    if (!saturates && !is_coarse(samples, sensor, density * std::sqrt(noise.rate_hz)))
      check_repeats(samples, sensor, noise.rate_hz, out);
  }
  return out;
}

}  // namespace host
