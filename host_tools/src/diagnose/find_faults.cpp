#include <algorithm>

#include "diagnose/fault.h"
#include "imu_temperature.h"

namespace host {
namespace {

bool holds(const std::vector<Fault>& faults, const char* kind) {
  for (const Fault& f : faults)
    if (f.kind == kind) return true;
  return false;
}

}  // namespace

std::vector<Fault> temperature_faults(const Recording& recording) {
  const TemperatureJumps& jumps = recording.imu.temperature_jumps;
  if (jumps.count == 0) return {};
  return {{"temperature_spikes", "imu", jumps.first_ns, jumps.last_ns, jumps.count, jumps.share, few_temperature_jumps,
           "-", temperature_words(recording.imu)}};
}

bool spoil_fits(const std::vector<Fault>& faults) {
  return std::any_of(faults.begin(), faults.end(), [](const Fault& f) { return f.spoils_fits(); });
}

std::string in_words(const std::vector<Fault>& faults) {
  const Fault& f = faults.front();
  return f.kind + " in " + f.sensor + ": " + f.words +
         (faults.size() > 1 ? " (" + std::to_string(faults.size() - 1) + " more)" : "");
}

std::vector<Fault> find_faults(const Recording& recording, const Calibration& start) {
  std::vector<Fault> all;
  const auto add = [&all](std::vector<Fault> faults) {
    for (Fault& f : faults) {
      const bool known = std::any_of(all.begin(), all.end(),
                                     [&f](const Fault& g) { return g.kind == f.kind && g.sensor == f.sensor; });
      if (!known) all.push_back(std::move(f));
    }
  };
  add(stamp_faults(recording));
  add(value_faults(recording));
  add(temperature_faults(recording));
  add(magnitude_faults(recording));
  add(image_faults(recording, start));
  if (!holds(all, "image_size")) add(track_faults(recording, start));
  // Where stamps or values cannot be used at all there is nothing to compare the images with.
  if (!holds(all, "no_overlap") && !holds(all, "not_finite")) add(rotation_faults(recording, start));
  return all;
}

}  // namespace host
