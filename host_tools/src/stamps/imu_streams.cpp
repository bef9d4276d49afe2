#include "stamps/imu_streams.h"

#include <cstdio>

#include "csv.h"
#include "stamps/smooth_stamps.h"

namespace host {
namespace {

struct Stream {
  std::vector<std::int64_t> t_ns;
  std::vector<std::array<double, 3>> value;
};

Stream read_stream(const std::filesystem::path& file, const char* columns) {
  Stream out;
  CsvReader csv(file, columns, 4, 5);
  while (csv.next_row()) {
    const std::int64_t t_ns = csv.stamp(0);
    if (!out.t_ns.empty() && t_ns < out.t_ns.back())
      csv.fail("stamps that do not go back: two streams can only be joined in order of time");
    if (!out.t_ns.empty() && t_ns == out.t_ns.back()) continue;  // the same event twice
    out.t_ns.push_back(t_ns);
    out.value.push_back({csv.number(1), csv.number(2), csv.number(3)});
  }
  return out;
}

void smooth_stream(const char* name, Stream* stream, std::vector<std::string>* notes) {
  SmoothedStamps smooth = smooth_stamps(stream->t_ns);
  notes->push_back(smoothing_note(name, smooth.t_ns.size(), smooth.period_s, smooth.moved_rms_s, smooth.moved_most_s,
                                  smooth.missing));
  stream->t_ns = std::move(smooth.t_ns);
}

}  // namespace

std::string smoothing_note(const std::string& stream, std::size_t events, double period_s, double rms_s, double most_s,
                           std::size_t missing) {
  char text[200];
  std::snprintf(text, sizeof text,
                "%s: %zu stamps smoothed by a robust local line, period %.3f ms: moved by %.2f ms rms, %.1f ms at "
                "most; %zu events missing",
                stream.c_str(), events, 1e3 * period_s, 1e3 * rms_s, 1e3 * most_s, missing);
  return text;
}

std::vector<ImuSample> read_imu_streams(const std::filesystem::path& folder, bool smooth,
                                        std::vector<std::string>* notes) {
  Stream gyro = read_stream(folder / "gyro.csv", "timestamp [ns], w_x, w_y, w_z [rad/s]");
  Stream accel = read_stream(folder / "accel.csv", "timestamp [ns], a_x, a_y, a_z [m/s^2]");
  if (smooth) {
    smooth_stream("gyro", &gyro, notes);
    smooth_stream("accel", &accel, notes);
  }
  std::vector<ImuSample> out;
  std::size_t k = 0;
  for (std::size_t i = 0; i < gyro.t_ns.size(); ++i) {
    const std::int64_t t = gyro.t_ns[i];
    while (k + 2 < accel.t_ns.size() && accel.t_ns[k + 1] < t) ++k;
    if (accel.t_ns.size() < 2 || t < accel.t_ns[k] || t > accel.t_ns[k + 1]) continue;
    const double share =
        static_cast<double>(t - accel.t_ns[k]) / static_cast<double>(accel.t_ns[k + 1] - accel.t_ns[k]);
    ImuSample sample;
    sample.t_ns = t;
    sample.gyro = gyro.value[i];
    for (std::size_t c = 0; c < 3; ++c)
      sample.accel[c] = accel.value[k][c] + share * (accel.value[k + 1][c] - accel.value[k][c]);
    out.push_back(sample);
  }
  if (out.empty())
    throw InputError((folder / "accel.csv").string() + ": expected stamps that overlap those of gyro.csv, found none");
  return out;
}

}  // namespace host
