// Stamps: do they go forward, at the stated rate, evenly, without holes, and do camera and IMU run at the same time?
#include <algorithm>
#include <cmath>

#include "diagnose/fault.h"
#include "formatted.h"
#include "quantile.h"

namespace host {
namespace {

// A missing sample is bridged by a straight line between its neighbours; one in five hundred is what the filter and the
// segments were measured with, one in fifty is 4 % of the time.
constexpr double most_missing_share = 0.002;
constexpr double longest_imu_gap_s = 0.1;  // over which the motion is unknown
constexpr double most_back_share = 0.001;
// At 20 rad/s^2, a brisk hand, a stamp 5 % of 5 ms off is an error of 0.005 rad/s, twice a sample's noise.
constexpr double most_imu_jitter = 0.05;         // of the interval
constexpr double most_camera_jitter_s = 0.0007;  // of intervals: stamps within half a millisecond
constexpr double most_rate_error = 0.1;          // of sensor.yaml's rate
constexpr double least_covered_share = 0.9;      // of the frames, by IMU samples

template <typename Stamped>
std::vector<double> intervals(const std::vector<Stamped>& entries) {
  std::vector<double> out;
  for (std::size_t k = 1; k < entries.size(); ++k)
    out.push_back(static_cast<double>(entries[k].t_ns - entries[k - 1].t_ns) * 1e-9);
  return out;
}

template <typename Stamped>
void check_order(const std::vector<Stamped>& entries, const std::vector<double>& dt, const std::string& sensor,
                 std::vector<Fault>& out) {
  Fault fault{"stamps_back", sensor, 0, 0, 0, 0, most_back_share, "-", ""};
  for (std::size_t k = 0; k < dt.size(); ++k) {
    if (dt[k] > 0) continue;
    if (!fault.count++) fault.first_ns = entries[k + 1].t_ns;
    fault.last_ns = entries[k + 1].t_ns;
  }
  fault.value = static_cast<double>(fault.count) / static_cast<double>(dt.size());
  if (fault.value <= most_back_share) return;
  fault.words =
      sensor +
      formatted(
          ": %.0f stamps repeat or go back. Write the log in the order of measurement, with the sensor's own clock.",
          static_cast<double>(fault.count));
  out.push_back(fault);
}

/// Extra time between sample k and the next, in periods: the mean of the five stamps after against the five before, so
/// that jitter, which the neighbours make up for, is no hole.
double extra_periods(const std::vector<ImuSample>& samples, std::size_t k, double period) {
  const std::size_t n = std::min<std::size_t>({5, k + 1, samples.size() - k - 1});
  double sum = 0;
  for (std::size_t i = 0; i < n; ++i) sum += static_cast<double>(samples[k + 1 + i].t_ns - samples[k - i].t_ns) * 1e-9;
  return (sum / static_cast<double>(n) - period * static_cast<double>(n)) / period;
}

/// IMU samples that are missing: holes of a whole number of periods.
void check_missing(const std::vector<ImuSample>& samples, const std::vector<double>& dt, double period,
                   std::vector<Fault>& out) {
  Fault fault{"dropped_samples", "imu", 0, 0, 0, 0, most_missing_share, "-", ""};
  double longest = 0;
  std::size_t missing = 0;
  for (std::size_t k = 0; k < dt.size(); ++k) {
    if (dt[k] < 1.5 * period || extra_periods(samples, k, period) < 0.5) continue;
    if (!fault.count++) fault.first_ns = samples[k].t_ns;
    fault.last_ns = samples[k].t_ns;
    missing += static_cast<std::size_t>(std::lround(dt[k] / period)) - 1;
    longest = std::max(longest, dt[k]);
  }
  fault.value = static_cast<double>(missing) / static_cast<double>(samples.size() + missing);
  if (longest <= longest_imu_gap_s && fault.value <= most_missing_share) return;
  fault.words = formatted("IMU: %.0f samples are missing in %.0f gaps, the longest %.0f ms. ",
                          static_cast<double>(missing), static_cast<double>(fault.count), 1e3 * longest) +
                "Look for a full queue or a bus that is too slow between the sensor and the log.";
  out.push_back(fault);
}

/// Spread of the intervals that are no holes; robust, so that a few odd ones are no jitter.
double spread_of(const std::vector<double>& dt, double period) {
  std::vector<double> off;
  for (double d : dt)
    if (d > 0 && d < 1.5 * period) off.push_back(std::abs(d - period));
  return off.size() < 20 ? 0 : 1.4826 * quantile(std::move(off), 0.5);
}

template <typename Stamped>
void check_jitter(const std::vector<Stamped>& entries, const std::vector<double>& dt, double limit_s,
                  const std::string& sensor, std::vector<Fault>& out) {
  const double spread = spread_of(dt, quantile(dt, 0.5));
  if (spread <= limit_s) return;
  out.push_back(
      {"stamp_jitter", sensor, entries.front().t_ns, entries.back().t_ns, dt.size(), spread, limit_s, "s",
       sensor +
           formatted(": intervals between stamps scatter by %.2f ms (limit %.2f ms). ", 1e3 * spread, 1e3 * limit_s) +
           "Stamp at the moment of measurement (interrupt or trigger), not when the data arrive."});
}

void check_rate(const ImuData& imu, double period, std::vector<Fault>& out) {
  const double off = std::abs(period * imu.noise.rate_hz - 1);
  if (off <= most_rate_error) return;
  const double decades = std::log10(1 / (period * imu.noise.rate_hz));
  const bool off_by_unit = std::abs(decades - 3 * std::round(decades / 3)) < 0.05 && std::abs(decades) > 2;
  out.push_back(
      {"rate", "imu", imu.samples.front().t_ns, imu.samples.back().t_ns, imu.samples.size(), 1 / period,
       imu.noise.rate_hz, "Hz",
       formatted("IMU: samples come at %.1f Hz, sensor.yaml states %.1f Hz. ", 1 / period, imu.noise.rate_hz) +
           (off_by_unit ? "Stamps are in ns: these may be in us or ms."
                        : "State the rate at which the log was written, or log every sample.")});
}

/// Frames without IMU samples around them.
void check_overlap(const Recording& recording, std::size_t camera, std::vector<Fault>& out) {
  const auto [first, last] =
      std::minmax_element(recording.imu.samples.begin(), recording.imu.samples.end(),
                          [](const ImuSample& a, const ImuSample& b) { return a.t_ns < b.t_ns; });
  const std::string name = "cam" + std::to_string(camera);
  const std::vector<Frame>& frames = recording.cameras[camera].frames;
  Fault fault{"no_overlap", name, 0, 0, 0, 0, least_covered_share, "-", ""};
  for (const Frame& frame : frames) {
    if (frame.t_ns >= first->t_ns && frame.t_ns <= last->t_ns) continue;
    if (!fault.count++) fault.first_ns = frame.t_ns;
    fault.last_ns = frame.t_ns;
  }
  fault.value = 1 - static_cast<double>(fault.count) / static_cast<double>(frames.size());
  if (fault.value >= least_covered_share) return;
  fault.words = name +
                formatted(": only %.0f %% of the frames fall into the time of the IMU samples. ", 100 * fault.value) +
                "Stamp both with one clock, or correct the offset between their clocks first.";
  out.push_back(fault);
}

/// Images that the reader set aside (stamps/stray_frames.h).
void note_strays(const std::vector<Frame>& strays, std::size_t n, const std::string& sensor, std::vector<Fault>& out) {
  if (strays.empty()) return;
  std::string words =
      sensor +
      formatted(": the stamps of %zu of %zu images lie apart, ahead of the others, the first at %.3f s (%lld ns). ",
                strays.size(), strays.size() + n, static_cast<double>(strays.front().t_ns) * 1e-9,
                static_cast<long long>(strays.front().t_ns));
  words += "They are left out: look at how the driver makes its stamps.";
  out.push_back({"stray_stamps", sensor, strays.front().t_ns, strays.back().t_ns, strays.size(),
                 static_cast<double>(strays.size()) / static_cast<double>(strays.size() + n), most_back_share, "-",
                 words});
}

}  // namespace

std::vector<Fault> stamp_faults(const Recording& recording) {
  std::vector<Fault> out;
  const std::vector<ImuSample>& samples = recording.imu.samples;
  if (samples.size() < 20) return out;
  const std::vector<double> dt = intervals(samples);
  const double period = quantile(dt, 0.5);
  check_order(samples, dt, "imu", out);
  if (period > 0) {
    check_missing(samples, dt, period, out);
    check_jitter(samples, dt, most_imu_jitter * period, "imu", out);
    check_rate(recording.imu, period, out);
  }
  for (std::size_t i = 0; i < recording.cameras.size(); ++i) {
    const std::vector<Frame>& frames = recording.cameras[i].frames;
    if (frames.size() < 20) continue;
    const std::vector<double> frame_dt = intervals(frames);
    const std::string name = "cam" + std::to_string(i);
    note_strays(recording.cameras[i].strays, frames.size(), name, out);
    check_order(frames, frame_dt, name, out);
    check_jitter(frames, frame_dt, most_camera_jitter_s, name, out);
    check_overlap(recording, i, out);
  }
  return out;
}

}  // namespace host
