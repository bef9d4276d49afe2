// Samples that stand alone: far from where those before lead, as the one after is not.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "diagnose/fault.h"
#include "diagnose/spike_gate.h"
#include "formatted.h"

namespace host {
namespace {

using Gate = SpikeGate<double>;
using Reading = InertialReading<double>;

/// Share of the samples from which it is said: of real ones at impacts, sampled without a filter, 1 in 3,000 stands alone.
constexpr double least_share = 0.001;
constexpr double least_rate_hz = 100;   // of a slower IMU one period may be a twitch of 30 ms
constexpr double gyro_range = 35, accel_range = 157;   // rad/s, m/s^2: at its full scale the device leaves a sample out by itself

Reading reading_of(const ImuSample& s) { return {{s.gyro[0], s.gyro[1], s.gyro[2]}, {s.accel[0], s.accel[1], s.accel[2]}}; }

/// The device takes it.
bool is_taken(const Reading& r) {
  return r.gyro.allFinite() && r.accel.allFinite() && r.gyro.cwiseAbs().maxCoeff() < gyro_range && r.accel.cwiseAbs().maxCoeff() < accel_range;
}

}  // namespace

std::vector<std::size_t> spikes_of(const Recording& recording) {
  const ImuNoise& noise = recording.imu.noise;
  const double root_rate = std::sqrt(noise.rate_hz);
  std::vector<std::size_t> found;
  if (noise.rate_hz < least_rate_hz) return found;
  Gate gate;
  gate.begin(noise.gyro_noise_density * root_rate, noise.accel_noise_density * root_rate);
  std::size_t held = 0;
  for (std::size_t i = 0; i < recording.imu.samples.size(); ++i) {
    const Reading reading = reading_of(recording.imu.samples[i]);
    if (!is_taken(reading)) continue;
    if (gate.holds() && gate.is_spike(reading)) {
      found.push_back(held);
      gate.leave_out();
    } else if (gate.holds()) {
      gate.follow(gate.held());
    }
    held = i;
    gate.jumps(reading) ? gate.hold(recording.imu.samples[i].t_ns, reading) : gate.follow(reading);
  }
  return found;
}

std::vector<Fault> spike_faults(const Recording& recording, const std::vector<std::size_t>& spikes) {
  const std::vector<ImuSample>& samples = recording.imu.samples;
  const double share = static_cast<double>(spikes.size()) / static_cast<double>(std::max<std::size_t>(samples.size(), 1));
  if (share < least_share) return {};
  double gyro = 0, accel = 0;   // largest distance from the sample before
  for (const std::size_t i : spikes) {
    const Reading here = reading_of(samples[i]), before = reading_of(samples[i > 0 ? i - 1 : 0]);
    gyro = std::max(gyro, (here.gyro - before.gyro).norm());
    accel = std::max(accel, (here.accel - before.accel).norm());
  }
  return {{"spikes", "imu", samples[spikes.front()].t_ns, samples[spikes.back()].t_ns, spikes.size(), share, least_share, "-",
           formatted("IMU: %zu samples (%.2f %%) stand alone, up to %.3g rad/s and %.3g m/s^2 from the ones before and after, which agree. They are taken "
                     "for motion: look at the sensor's bus, and at what knocks against it, or leave them out of the log.",
                     spikes.size(), 100 * share, gyro, accel)}};
}

}  // namespace host
