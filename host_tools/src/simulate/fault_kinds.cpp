#include "simulate/fault_kinds.h"

#include <cmath>

#include "angles.h"
#include "simulate/disturb.h"
#include "simulate/spoil.h"

namespace host::sim {
namespace {

using disturb::Sensor;
using Seed = std::uint64_t;

constexpr double millisecond = 1e-3;

void nothing(Recording&, Seed) {}

std::vector<FaultKind> stamp_kinds() {
  return {
      {"camera_jitter",
       "camera stamps scatter by 5 ms",
       {"jitter"},
       [](Recording& r, Seed s) { disturb::jitter_stamps(r, 0, 5 * millisecond, s); }},
      {"imu_jitter",
       "IMU stamps scatter by 1 ms",
       {"jitter"},
       [](Recording& r, Seed s) { disturb::jitter_stamps(r, millisecond, 0, s); }},
      {"camera_late",
       "camera stamps 10 ms late",
       {"time_offset", "clock"},
       [](Recording& r, Seed) { disturb::shift_camera_stamps(r, 10 * millisecond); }},
      {"camera_late_unasked",
       "the same, and the clocks are not compared first (--keep-clock)",
       {"time_offset", "clock", "shifted by"},
       [](Recording& r, Seed) { disturb::shift_camera_stamps(r, 10 * millisecond); },
       "",
       true},
      {"imu_clock_jump",
       "the IMU's clock jumps by 0.5 s in the middle",
       {"imu_gaps", "clock", "far", "dropped_samples"},
       [](Recording& r, Seed) { spoil::jump_imu(r, 0.5); }},
      {"imu_clock_back",
       "the IMU's clock jumps back by 0.5 s in the middle",
       {"stamps_back", "clock"},
       [](Recording& r, Seed) { spoil::jump_imu(r, -0.5); }},
      {"camera_clock_jump",
       "the camera's clock jumps by 0.5 s in the middle",
       {"clock", "frames_dropped", "time_offset"},
       [](Recording& r, Seed) { spoil::jump_camera(r, 0.5); }},
      {"camera_clock_back",
       "the camera's clock jumps back by 0.5 s in the middle",
       {"stamps_back", "clock", "time_offset"},
       [](Recording& r, Seed) { spoil::jump_camera(r, -0.5); }},
      {"stamp_in_future",
       "one IMU stamp 9.8 h ahead",
       {"far", "stamps_back"},
       [](Recording& r, Seed) { spoil::sample(r, 0.3).t_ns += 35280000000000; }},
      {"reversal",
       "every 100th IMU sample swapped with the one before",
       {"stamps_back"},
       [](Recording& r, Seed) { spoil::swap_samples(r, 100); }},
      {"duplicates",
       "every 50th IMU sample and every 10th image twice",
       {"stamps_back"},
       [](Recording& r, Seed) { spoil::duplicate(r, 50, 10); }},
  };
}

std::vector<FaultKind> loss_kinds() {
  return {
      {"imu_gaps",
       "three gaps of 0.3 s in the IMU's samples",
       {"gaps", "dropped_samples"},
       [](Recording& r, Seed) {
         for (double p : {0.3, 0.5, 0.7}) spoil::lose_imu(r, p, 0.3);
       }},
      {"imu_dropped_10",
       "10 % of the IMU samples missing, at random",
       {"gaps", "dropped_samples"},
       [](Recording& r, Seed s) { spoil::drop_samples(r, 0.1, s); }},
      {"imu_dropped_30",
       "30 % of them",
       {"gaps", "dropped_samples"},
       [](Recording& r, Seed s) { spoil::drop_samples(r, 0.3, s); }},
      {"imu_bursts",
       "50 ms of IMU samples missing every 2 s",
       {"gaps", "dropped_samples"},
       [](Recording& r, Seed) { spoil::lose_bursts(r, 2, 0.05); }},
      {"frames_dropped_10",
       "10 % of the images missing, at random",
       {"frames_dropped"},
       [](Recording& r, Seed s) { spoil::drop_frames(r, 0.1, s); }},
      {"frames_dropped_30",
       "30 % of them",
       {"frames_dropped"},
       [](Recording& r, Seed s) { spoil::drop_frames(r, 0.3, s); }},
      {"imu_rate_halved",
       "every second IMU sample missing from the middle on",
       {"gaps", "rate", "dropped_samples"},
       [](Recording& r, Seed) { spoil::halve_imu_rate(r); }},
      {"camera_rate_halved",
       "every second image missing from the middle on",
       {"frames_dropped"},
       [](Recording& r, Seed) { spoil::halve_camera_rate(r); }},
  };
}

std::vector<FaultKind> value_kinds() {
  return {
      {"not_a_number",
       "1 % of the IMU samples hold NaN",
       {"not_finite"},
       [](Recording& r, Seed s) { spoil::spikes(r, 0.01, std::nan(""), s); }},
      {"spikes_beyond_range",
       "0.5 % of the accelerations 300 m/s^2",
       {"saturat"},
       [](Recording& r, Seed s) { spoil::spikes(r, 0.005, 300, s); }},
      {"spikes_inside_range",
       "0.5 % of the accelerations 30 m/s^2",
       {"spikes"},
       [](Recording& r, Seed s) { spoil::spikes(r, 0.005, 30, s); }},
      {"bits_flipped",
       "in 1 % of the IMU samples one of 16 bits of one axis",
       {"spikes"},
       [](Recording& r, Seed s) { spoil::flip_bits(r, 0.01, s); }},
      {"saturation_known",
       "a gyroscope that clips at half of what it should show, its readings there at full scale",
       {"saturat"},
       [](Recording& r, Seed) { spoil::saturate(r, 0.5, true); }},
      {"saturation_unknown",
       "the same, and the clipped readings look like others",
       {"saturat"},
       [](Recording& r, Seed) { spoil::saturate(r, 0.5, false); }},
      {"gyro_stuck",
       "the gyroscope repeats a reading for 2 s",
       {"frozen"},
       [](Recording& r, Seed) { disturb::freeze(r, Sensor::gyro, disturb::middle_ns(r), 2); }},
      {"accel_z_stuck",
       "the accelerometer's z axis repeats its first reading",
       {"frozen", "accel"},
       [](Recording& r, Seed) { spoil::freeze_accel_z(r); }},
      {"gyro_bias_step",
       "the gyroscope's x reads 0.01 rad/s more from the middle on",
       {"bias_step"},
       [](Recording& r, Seed) {
         disturb::offset(r, Sensor::gyro, {0.01, 0, 0}, disturb::middle_ns(r));
       }},
      {"accel_bias_step",
       "the accelerometer's x reads 0.3 m/s^2 more from the middle on",
       {"bias_step"},
       [](Recording& r, Seed) {
         disturb::offset(r, Sensor::accel, {0.3, 0, 0}, disturb::middle_ns(r));
       }},
      {"gyro_degrees",
       "the gyroscope in deg/s",
       {"unit"},
       [](Recording& r, Seed) { disturb::scale(r, Sensor::gyro, Eigen::Vector3d::Constant(deg_per_rad)); }},
      {"accel_g",
       "the accelerometer in g",
       {"unit"},
       [](Recording& r, Seed) { disturb::scale(r, Sensor::accel, Eigen::Vector3d::Constant(1 / 9.80665)); }},
      {"gyro_axes",
       "the gyroscope's x and y swapped",
       {"axes"},
       [](Recording& r, Seed) { disturb::reorder_axes(r, Sensor::gyro, "yx-z"); }},
      {"accel_axes",
       "the accelerometer's y with the wrong sign",
       {"axes"},
       [](Recording& r, Seed) { disturb::reorder_axes(r, Sensor::accel, "x-yz"); }},
  };
}

std::vector<FaultKind> image_kinds() {
  return {
      {"outliers_random",
       "30 % of the tracks anywhere in the image",
       {"pixel_noise", "outlier"},
       [](Recording& r, Seed s) { spoil::outliers(r, 0.3, 0, s); }},
      {"outliers_drifting",
       "30 % of the tracks run off by 20 px/s",
       {"pixel_noise", "outlier"},
       [](Recording& r, Seed s) { spoil::outliers(r, 0.3, 20, s); }},
      {"ids_permuted",
       "the track ids of every 20th image permuted",
       {"mixed_tracks", "pixel_noise", "outlier"},
       [](Recording& r, Seed s) { spoil::permute_ids(r, 20, s); }},
      {"ids_repeated",
       "track ids modulo 97: several corners with one",
       {"points_repeated"},
       [](Recording& r, Seed) { spoil::reuse_ids(r, 97); }},
      {"tracks_lost",
       "all tracks end in the middle, others begin",
       {"lost_tracks", "few_tracks", "restart"},
       [](Recording& r, Seed) { spoil::renumber_from_middle(r); }},
      {"camera_covered",
       "no corners for 3 s",
       {"few_tracks", "frames_dropped"},
       [](Recording& r, Seed) { spoil::cover(r, 3); }},
      {"half_resolution",
       "images of half the calibrated size",
       {"image_size"},
       [](Recording& r, Seed) { spoil::scale_pixels(r, 0.5); }},
      {"principal_point_moves",
       "the principal point moves by 4 px in the middle",
       {"calibration_shift", "moved", "disagree", "outdated"},
       [](Recording& r, Seed) { spoil::move_pixels(r, 4, 0); }},
      {"lens_moves",
       "the camera turns by 2 deg against the IMU in the middle",
       {"calibration_shift", "moved", "disagree", "outdated"},
       nothing,
       "calibration_shift=cam0.r_CI,20,0.03,-0.02,0"},
  };
}

}  // namespace

const std::vector<FaultKind>& fault_kinds() {
  static const std::vector<FaultKind> all = [] {
    std::vector<FaultKind> kinds = {{"none", "a clean recording", {}, nothing}};
    for (const auto& group : {stamp_kinds(), loss_kinds(), value_kinds(), image_kinds()})
      kinds.insert(kinds.end(), group.begin(), group.end());
    return kinds;
  }();
  return all;
}

std::string fault_kind_names() {
  std::string text;
  std::size_t line = 0;
  for (const FaultKind& kind : fault_kinds()) {
    if (kind.names.empty() || kind.keep_clock) continue;
    const std::string name = kind.name;
    if (line + name.size() > 90 || text.empty()) {
      text += "\n  ";
      line = 0;
    }
    text += name + " ";
    line += name.size() + 1;
  }
  return text;
}

const FaultKind& fault_kind(const std::string& name) {
  for (const FaultKind& kind : fault_kinds())
    if (name == kind.name) return kind;
  throw InputError("unknown fault '" + name + "': `segcal simulate --help` lists them");
}

}  // namespace host::sim
