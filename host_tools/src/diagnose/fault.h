// Faults of the data that no model explains: found by direct
// checks before any fit, so that they are not taken for effects.
#pragma once

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "calibration_file.h"
#include "recording.h"

namespace host {

/// One finding. `kind` is one of: saturation, spikes, dropped_samples, stamp_jitter, stamps_back, stray_stamps,
/// temperature_spikes, not_finite, frozen, unit, axes, gravity_norm, rate, no_overlap, clock_offset, clock_drift,
/// image_size, outlier_tracks, mixed_tracks, lost_tracks.
struct Fault {
  std::string kind;
  std::string sensor;         ///< gyro, accel, imu, cam0, ...; with an axis: gyro.x
  std::int64_t first_ns = 0;  ///< stamp of the first place
  std::int64_t last_ns = 0;   ///< and of the last
  std::size_t count = 0;      ///< samples, gaps or frames concerned
  double value = 0;           ///< the size that was compared with the limit
  double limit = 0;
  std::string unit;   ///< of value and limit
  std::string words;  ///< what it is, and what to do: one sentence each

  /// Worth knowing, and hardly why odometry went wrong: tracks that end and begin anew are only fewer, a few spikes the
  /// end of a segment each, and images with stamps of their own were left out, temperatures that jump are not used.
  bool is_remark() const {
    return kind == "lost_tracks" || kind == "stray_stamps" || kind == "temperature_spikes" ||
           (kind == "spikes" && value < limit);
  }
  /// Gravity that is off by less than a tenth. A range setting is off by a factor; this may be what the accelerometer's
  /// bias does with temperature, or its scale with force, which fits are to tell.
  bool is_small_gravity() const { return kind == "gravity_norm" && std::abs(value / 9.80665 - 1) < 0.1; }
  /// Whether fits to such data say little. A few spikes end as many segments, and corners that move unlike the rest may
  /// be good ones of another lens, which fits are to tell.
  bool spoils_fits() const { return !is_remark() && !is_small_gravity() && kind != "outlier_tracks"; }
};

bool spoil_fits(const std::vector<Fault>& faults);
/// The first one of some, and how many more there are.
std::string in_words(const std::vector<Fault>& faults);

/// All checks; empty for a sound recording. `start` need not be precise: a few degrees, a few percent. Never throws on
/// data: what cannot be judged (too short, too still, no tracks) is passed over.
std::vector<Fault> find_faults(const Recording& recording, const Calibration& start);

// The groups of checks, one file each.
std::vector<Fault> stamp_faults(const Recording& recording);        ///< order, gaps, jitter, rate, overlap
std::vector<Fault> value_faults(const Recording& recording);        ///< spikes, saturation, repeats, not a number
std::vector<Fault> temperature_faults(const Recording& recording);  ///< readings that jump away and back
std::vector<Fault> magnitude_faults(const Recording& recording);    ///< gravity norm, g, deg/s
std::vector<Fault> image_faults(const Recording& recording,
                                const Calibration& start);  ///< corners that the image cannot have
std::vector<Fault> track_faults(const Recording& recording,
                                const Calibration& start);  ///< corners that do not belong to one scene
std::vector<Fault> rotation_faults(const Recording& recording,
                                   const Calibration& start);  ///< axes, deg/s, clocks: gyroscope and image

/// Places of IMU samples that stand alone, one or two in a row, among those that the device takes.
std::vector<std::size_t> spikes_of(const Recording& recording);
std::vector<Fault> spike_faults(const Recording& recording, const std::vector<std::size_t>& spikes);

}  // namespace host
