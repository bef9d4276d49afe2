// Hidden effects in a real recording: put in by changing its stamps and samples, and as it is.
#include <algorithm>
#include <cmath>

#include "experiments/hidden_answer.h"
#include "experiments/registry.h"
#include "experiments/statistics.h"
#include "experiments/wrong_lens.h"
#include "simulate/disturb.h"

namespace host::experiments {
namespace {

constexpr double largest_offset_error = 0.5e-3;  // s
constexpr double clipped_share = 0.04;           // of the samples of the axis that is clipped most

/// What is done to the recording, and what the answer must be.
struct RealCase {
  const char* name;
  std::vector<std::string> expected;  ///< any of these names
  bool camera_side;                   ///< the expected name belongs to the lens: an unlisted term will do
};

const std::vector<RealCase>& real_cases() {
  static const std::vector<RealCase> all = {
      {"unchanged", {}, false},
      {"stamps_plus_3ms", {"time_offset"}, false},
      {"stamps_minus_6ms", {"time_offset"}, false},
      {"gyro_z_scaled_after_half", {"calibration_shift"}, false},
      {"every_50th_dropped", {"dropped_samples"}, false},
      {"g_sensitivity", {"gyro_g_sensitivity"}, false},
      {"accel_clipped", {"saturation"}, false},
      {"fov_for_radtan", {"radial_residual", "tangential_residual", "unlisted"}, true},
  };
  return all;
}

constexpr double turning = 0.05;  // rad/s: above what a device at rest reads

/// Middle of the time in which the device turns and there are images: what changes while it stands shows nowhere.
std::int64_t middle_of_motion_ns(const Recording& recording) {
  const auto& frames = recording.cameras[0].frames;
  std::vector<std::int64_t> moving;
  for (const ImuSample& s : recording.imu.samples) {
    const bool seen = s.t_ns >= frames.front().t_ns && s.t_ns <= frames.back().t_ns;
    if (seen && std::hypot(s.gyro[0], s.gyro[1], s.gyro[2]) > turning) moving.push_back(s.t_ns);
  }
  return moving.empty() ? frames.front().t_ns : moving[moving.size() / 2];
}

/// The limit that clips the given share of one axis' samples while there are images.
double clip_limit(const Recording& recording) {
  const auto& frames = recording.cameras[0].frames;
  double limit = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    std::vector<double> sizes;
    for (const ImuSample& s : recording.imu.samples)
      if (s.t_ns >= frames.front().t_ns && s.t_ns <= frames.back().t_ns) sizes.push_back(std::abs(s.accel[axis]));
    limit = std::max(limit, quantile(std::move(sizes), 1 - clipped_share));  // the axis that carries gravity
  }
  return limit;
}

/// A camera stamp s late is corrected by t_d = -s: the expected change of the estimate.
double disturb_recording(const std::string& name, Recording& recording, Calibration& start) {
  if (name == "stamps_plus_3ms" || name == "stamps_minus_6ms") {
    const double shift = name == "stamps_plus_3ms" ? 3e-3 : -6e-3;
    disturb::shift_camera_stamps(recording, shift);
    return -shift;
  }
  if (name == "gyro_z_scaled_after_half")
    disturb::scale(recording, disturb::Sensor::gyro, {1, 1, 1.01}, middle_of_motion_ns(recording));
  if (name == "every_50th_dropped") disturb::drop_imu_samples(recording, 50);
  if (name == "g_sensitivity") disturb::add_g_sensitivity(recording, 3e-4 * Eigen::Matrix3d::Identity());
  if (name == "accel_clipped") disturb::clip(recording, 0, clip_limit(recording));
  if (name == "fov_for_radtan") start.cameras[0] = as_fov(start.cameras[0]);
  return 0;
}

double offset_in(const Json& answer, double without) {
  const Json& values = answer.at("values");
  return values.contains("time_offset.t_d") ? values["time_offset.t_d"][0].get<double>() : without;
}

const RealCase& case_named(const std::string& name) {
  for (const RealCase& c : real_cases())
    if (name == c.name) return c;
  throw InputError("hidden_real: unknown case '" + name + "'");
}

bool is_named(const RealCase& c, const Json& answer) {
  std::vector<std::string> said = answer.at("named").get<std::vector<std::string>>();
  if (answer.at("verdict") == "bad_data")
    for (const Json& kind : answer.at("faults")) said.push_back(kind);
  if (c.expected.empty()) return true;
  for (const std::string& name : said)
    if (std::find(c.expected.begin(), c.expected.end(), name) != c.expected.end()) return true;
  return false;
}

}  // namespace

std::vector<Cell> hidden_real_cells(const StudyOptions& options) {
  std::vector<Cell> cells;
  for (std::size_t i = 0; i < options.recordings.size(); ++i)
    for (const RealCase& c : real_cases())
      cells.push_back({"recording" + std::to_string(i) + "_" + c.name,
                       {{"recording", options.recordings[i].string()},
                        {"calibration", options.calibration.string()},
                        {"case", c.name}}});
  return cells;
}

Json hidden_real_run(const Json& parameters) {
  const std::string root = parameters.at("recording"), file = parameters.at("calibration");
  Recording recording = read_recording(root, 1);
  if (recording.cameras[0].frames.empty())
    throw InputError(root + "/mav0/cam0/tracks.csv: missing; run `segcal track " + root +
                     "` first to make it from the images");
  Calibration start = find_calibration(root, file, 1);
  const double offset = disturb_recording(parameters.at("case"), recording, start);
  return {{"offset_s", offset}, {"answer", diagnosed(recording, start)}};
}

Findings hidden_real_gather(const std::vector<CellResult>& cells) {
  Findings out;
  if (cells.empty())
    throw InputError(
        "experiments hidden_real: expected a recording with tracks, as in segcal experiments hidden_real REC --out "
        "DIR");
  Table table{"Hidden effects in a real recording",
              "",
              {{"recording", ""},
               {"case", ""},
               {"verdict", ""},
               {"named", ""},
               {"faults", ""},
               {"as expected", "-"},
               {"time offset put in", "ms"},
               {"time offset found", "ms"},
               {"gap closed", "-"},
               {"time", "s"}},
              {}};
  int unnamed = 0;
  double worst_offset = 0, unchanged_offset = 0;
  for (const CellResult& cell : cells) {
    const Json& answer = cell.result.at("answer");
    const RealCase& c = case_named(cell.parameters.at("case"));
    const bool right = is_named(c, answer);
    const double put_in = cell.result.at("offset_s"), found = offset_in(answer, 0);
    unnamed += right ? 0 : 1;
    if (put_in != 0) worst_offset = std::max(worst_offset, std::abs(found - put_in));
    if (c.expected.empty()) unchanged_offset = std::max(unchanged_offset, std::abs(found));
    table.rows.push_back({cell.parameters.at("recording"), c.name, answer.at("verdict"), answer.at("named").dump(),
                          answer.at("faults").dump(), right ? 1 : 0, 1e3 * put_in, 1e3 * found, answer.at("gap_closed"),
                          answer.at("seconds")});
  }
  out.tables = {table};
  out.limits.push_back({"changed recordings whose effect is not named", static_cast<double>(unnamed), 0, "-", false});
  out.limits.push_back({"largest error of a time offset", 1e3 * worst_offset, 1e3 * largest_offset_error, "ms", false});
  out.limits.push_back({"time offset named in the unchanged recording", 1e3 * unchanged_offset,
                        1e3 * largest_offset_error, "ms", false});
  return out;
}

}  // namespace host::experiments
