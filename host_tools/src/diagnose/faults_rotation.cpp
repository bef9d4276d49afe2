// The gyroscope against the image's rotation, and the accelerometer against the gyroscope: axes, units, clocks.
#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "angles.h"
#include "diagnose/accel_axes.h"
#include "diagnose/axis_orders.h"
#include "diagnose/clock.h"
#include "diagnose/compared_rates.h"
#include "diagnose/fault.h"
#include "diagnose/gyro_path.h"
#include "diagnose/image_rotation.h"
#include "formatted.h"
#include "quantile.h"

namespace host {
namespace {

constexpr std::size_t least_frame_pairs = 30;
constexpr double least_turning = 0.1;     // rad/s rms of the image: below it parallax looks the same
constexpr double other_order_fits = 0.9;  // correlation of another order of axes
// A start that is 0.05 rad askew and parallax leave 0.97; an axis
// that is turned about and holds a fortieth of the power, 0.95.
constexpr double as_is_fits = 0.95;
constexpr double better_by = 0.35;  // what is not explained, over that as it is
// Times the image's rates, half of what deg/s make: no range or scale error is so large.
constexpr double least_unit = 28;
constexpr double farthest_offset_s = 1.5, offset_step_s = 0.02;
// An offset below this is an effect (time_offset), above it the
// log is put together wrongly: the core's clock search ends here.
constexpr double largest_offset_s = 0.1;
constexpr double clock_fits = 0.8;       // correlation at an offset that is believed
constexpr double clock_better_by = 0.6;  // misfit at the best offset over the one at none
// Quartz clocks differ by up to 50e-6: 3 ms in a minute. 2 ms are four times what an offset may be wrong by.
constexpr double largest_change_s = 0.002;
constexpr double chance_of_drift = -4;  // log10 of how often a sound recording may show one

Fault whole(const Recording& recording, const char* kind, const char* sensor) {
  Fault fault;
  fault.kind = kind;
  fault.sensor = sensor;
  fault.first_ns = recording.imu.samples.front().t_ns;
  fault.last_ns = recording.imu.samples.back().t_ns;
  fault.count = recording.imu.samples.size();
  return fault;
}

/// Which order and signs of the gyroscope's axes agree with the images; the identity where none is clearly better.
AxisOrder check_gyro_axes(const Recording& recording, const ComparedRates& rates, const Eigen::Matrix3d& R_CI,
                          std::vector<Fault>& out) {
  AxisOrder best = axis_orders().front();
  const double as_is = rates.correlation(R_CI);
  double highest = as_is;
  for (const AxisOrder& order : axis_orders()) {
    const double c = rates.correlation(R_CI * order.P);
    if (c <= highest) continue;
    highest = c;
    best = order;
  }
  if (highest < other_order_fits || as_is > as_is_fits || 1 - highest > better_by * (1 - as_is))
    return axis_orders().front();
  Fault fault = whole(recording, "axes", "gyro");
  fault.value = highest;
  fault.limit = as_is_fits;
  fault.unit = "-";
  const bool mirrored = best.P.determinant() < 0;
  fault.words = formatted("gyroscope: it agrees with the rotation of the images (correlation %.2f, as it is %.2f) ",
                          highest, as_is) +
                "when its axes are read as " + best.name + (mirrored ? ", which is mirrored" : "") +
                ". Correct the axes in the driver" +
                (mirrored ? "." : ", or the camera's rotation R_CI in the starting calibration.");
  out.push_back(fault);
  return best;
}

void check_gyro_scale(const Recording& recording, const ComparedRates& rates, const Eigen::Matrix3d& R,
                      std::vector<Fault>& out) {
  const double c = rates.correlation(R), ratio = c * rates.gyro_rms() / rates.image_rms();
  if (c < 0.7 || ratio < least_unit) return;
  const auto is = [ratio](double unit) { return ratio > unit / 2 && ratio < unit * 2; };
  Fault fault = whole(recording, "unit", "gyro");
  fault.value = ratio;
  fault.limit = least_unit;
  fault.unit = "-";
  const std::string unit =
      is(deg_per_rad) ? "deg/s. Multiply by pi / 180"
      : is(1e3 * deg_per_rad)
          ? "mdeg/s. Multiply by pi / 180000"
          : formatted("raw counts. Multiply by what the data sheet says for the range that is set, here about 1 / %.0f",
                      ratio);
  fault.words = formatted("gyroscope: its rates are %.0f times those of the images, which is ", ratio) + unit +
                ": a recording has rad/s.";
  out.push_back(fault);
}

/// Offset of the clocks on a grid, by the correlation of the rates; 0 where none is clearly better.
double coarse_offset(const Recording& recording, const std::vector<FramePair>& pairs,
                     const std::vector<Eigen::Vector3d>& image, const GyroPath& gyro, const Eigen::Matrix3d& R,
                     std::vector<Fault>& out) {
  double best = 0, highest = rates_at(pairs, image, gyro, 0).correlation(R);
  const double as_is = highest;
  for (double offset = -farthest_offset_s; offset <= farthest_offset_s; offset += offset_step_s) {
    const ComparedRates rates = rates_at(pairs, image, gyro, offset);
    if (rates.size() < least_frame_pairs || 2 * rates.size() < pairs.size()) continue;
    const double c = rates.correlation(R);
    if (c <= highest) continue;
    highest = c;
    best = offset;
  }
  // Of the grid's two neighbours either may be best.
  const bool small = std::abs(best) <= largest_offset_s + 0.5 * offset_step_s;
  if (small || highest < clock_fits || 1 - highest > clock_better_by * (1 - as_is)) return small ? best : 0;
  Fault fault = whole(recording, "clock_offset", "cam0");
  fault.count = pairs.size();
  fault.value = best;
  fault.limit = largest_offset_s;
  fault.unit = "s";
  fault.words = formatted(
      "cam0: its stamps are %.2f s off the IMU's clock (t_imu = t_cam %+.2f s). "
      "Stamp both with one clock, or correct the offset first.",
      std::abs(best), best);
  out.push_back(fault);
  return best;
}

void check_drift(const Recording& recording, const std::vector<FramePair>& pairs, const GyroPath& gyro,
                 const Eigen::Matrix3d& R_CI, double offset, std::vector<Fault>& out) {
  const ClockDrift drift = drift_of(offsets_over_time(pairs, gyro, R_CI, offset));
  if (std::abs(drift.change) <= largest_change_s || drift.log10_p > chance_of_drift) return;
  Fault fault = whole(recording, "clock_drift", "cam0");
  fault.count = pairs.size();
  fault.value = drift.change;
  fault.limit = largest_change_s;
  fault.unit = "s";
  fault.words = formatted("cam0: its clock runs off the IMU's by %.1f ms over the recording (%.0f us per second). ",
                          1e3 * drift.change, 1e6 * drift.slope) +
                "Stamp both with one clock, or let them synchronise.";
  out.push_back(fault);
}

/// Mean of gyroscope minus image over the frames: with the images' translation averaged out, good to a hundredth of a
/// rad/s, and to a tenth where the camera moves one way and the lens is not known.
Eigen::Vector3d rough_bias(const std::vector<FramePair>& pairs, const std::vector<Eigen::Vector3d>& image,
                           const GyroPath& gyro, const Eigen::Matrix3d& R) {
  std::vector<double> off[3];
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    if (!gyro.covers(pairs[k].t1, pairs[k].t2)) continue;
    const Eigen::Vector3d d = gyro.mean_rate(pairs[k].t1, pairs[k].t2) - R.transpose() * image[k];
    for (int i = 0; i < 3; ++i) off[i].push_back(d[i]);
  }
  return {quantile(off[0], 0.5), quantile(off[1], 0.5), quantile(off[2], 0.5)};
}

}  // namespace

std::vector<Fault> rotation_faults(const Recording& recording, const Calibration& start) {
  std::vector<Fault> out;
  if (start.cameras.empty()) return out;
  const GyroPath gyro(recording);
  const std::vector<FramePair> pairs = frame_pairs(recording, start.cameras[0]);
  if (pairs.size() < least_frame_pairs) return out;
  std::vector<Eigen::Vector3d> image;
  for (const FramePair& pair : pairs) image.push_back(rate_by_rotation_alone(pair));
  const ComparedRates rates = rates_at(pairs, image, gyro, 0);
  if (rates.size() < least_frame_pairs || rates.image_rms() < least_turning) return out;
  const Eigen::Matrix3d R_CI = start.cameras[0].R_CI;
  const AxisOrder order = check_gyro_axes(recording, rates, R_CI, out);
  const Eigen::Matrix3d R = R_CI * order.P;
  check_gyro_scale(recording, rates, R, out);
  const bool in_degrees = std::any_of(out.begin(), out.end(), [](const Fault& f) { return f.kind == "unit"; });
  const Eigen::Vector3d bias = rough_bias(pairs, image, gyro, R);
  if (!in_degrees) accel_axes_fault(recording, gyro, bias, order.P, &out);
  if (!out.empty()) return out;  // clocks are compared on sound rates only
  const double offset = coarse_offset(recording, pairs, image, gyro, R, out);
  if (out.empty()) check_drift(recording, pairs, gyro, R_CI, offset, out);
  return out;
}

}  // namespace host
