// Single readings that no motion explains, as a device finds them whose stamps are in order and whose ranges are the
// usual ones (sensors/spike_watch.h).
#include "diagnose/fault.h"
#include "formatted.h"
#include "sensors/spike_watch.h"

namespace host {
namespace {

using SEGCAL_NS::InertialReading;

constexpr double gap_periods = 3;  // after which the readings before tell nothing
constexpr double gyro_range = 35,
                 accel_range = 157;  // rad/s, m/s^2: at full scale the device leaves a sample out by itself
// per second, from which no segment is whole: they are a cause of what goes wrong, and not a remark
constexpr double many = 0.25;

InertialReading<double> reading_of(const ImuSample& s) {
  return {{s.gyro[0], s.gyro[1], s.gyro[2]}, {s.accel[0], s.accel[1], s.accel[2]}};
}

bool is_taken(const InertialReading<double>& r) {
  return r.gyro.allFinite() && r.accel.allFinite() && r.gyro.cwiseAbs().maxCoeff() < gyro_range &&
         r.accel.cwiseAbs().maxCoeff() < accel_range;
}

}  // namespace

std::vector<std::size_t> spikes_of(const Recording& recording) {
  const std::vector<ImuSample>& samples = recording.imu.samples;
  const ImuNoise& noise = recording.imu.noise;
  SEGCAL_NS::SpikeWatch<double> watch;
  watch.begin({noise.gyro_noise_density, noise.gyro_random_walk, noise.accel_noise_density, noise.accel_random_walk},
              noise.rate_hz);
  std::vector<std::size_t> out;
  std::vector<std::size_t> taken;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const InertialReading<double> reading = reading_of(samples[i]);
    if (!is_taken(reading)) continue;
    const bool gap = !taken.empty() && static_cast<double>(samples[i].t_ns - samples[taken.back()].t_ns) * 1e-9 >
                                           gap_periods / noise.rate_hz;
    if (gap) watch.clear();
    const auto wrong = taken.end() - watch.after(reading);
    out.insert(out.end(), wrong, taken.end());
    taken.erase(wrong, taken.end());
    taken.push_back(i);
  }
  return out;
}

std::vector<Fault> spike_faults(const Recording& recording, const std::vector<std::size_t>& spikes) {
  if (spikes.empty()) return {};
  const std::vector<ImuSample>& samples = recording.imu.samples;
  const double seconds = static_cast<double>(samples.back().t_ns - samples.front().t_ns) * 1e-9;
  return {{"spikes", "imu", samples[spikes.front()].t_ns, samples[spikes.back()].t_ns, spikes.size(),
           static_cast<double>(spikes.size()) / seconds, many, "1/s",
           formatted("IMU: %zu of %zu samples stand alone, or two in a row, far from the ones before and after, the "
                     "first at stamp %lld ns. They are left out and end a segment: look at the sensor's bus, and at "
                     "what knocks against it.",
                     spikes.size(), samples.size(), static_cast<long long>(samples[spikes.front()].t_ns))}};
}

}  // namespace host
