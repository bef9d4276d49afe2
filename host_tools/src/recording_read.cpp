// Reading a recording folder. Format faults stop with file and line; data faults (NaN, repeats, gaps) pass through.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <map>
#include <unordered_set>

#include "csv.h"
#include "exposure_file.h"
#include "files/manifest.h"
#include "imu_data_file.h"
#include "imu_noise_file.h"
#include "imu_temperature.h"
#include "recording.h"
#include "stamps/imu_streams.h"
#include "stamps/smooth_stamps.h"
#include "stamps/stray_frames.h"

namespace host {
namespace {

namespace fs = std::filesystem;

constexpr const char* truth_columns = "timestamp [ns], p_x, p_y, p_z [m], q_w, q_x, q_y, q_z (, more)";

/// Stamps of one file, smoothed.
std::vector<std::int64_t> smoothed(const std::string& stream, const std::vector<std::int64_t>& t_ns,
                                   std::vector<std::string>* notes) {
  SmoothedStamps out = smooth_stamps(t_ns);
  notes->push_back(
      smoothing_note(stream, out.t_ns.size(), out.period_s, out.moved_rms_s, out.moved_most_s, out.missing));
  return std::move(out.t_ns);
}

ImuData read_imu(const fs::path& root, bool smooth, std::vector<std::string>* notes) {
  ImuData imu;
  const ImuNoise noise = read_recording_noise(root);
  imu.noise = noise;
  const fs::path folder = root / "mav0" / "imu0";
  if (!fs::exists(folder / "data.csv") && fs::exists(folder / "gyro.csv")) {
    imu.samples = read_imu_streams(folder, smooth, notes);
    return imu;
  }
  imu = read_imu_samples(folder / "data.csv");
  imu.noise = noise;
  if (smooth) {
    std::vector<std::int64_t> t_ns;
    for (const ImuSample& s : imu.samples) t_ns.push_back(s.t_ns);
    t_ns = smoothed("imu0", t_ns, notes);
    for (std::size_t i = 0; i < t_ns.size(); ++i) imu.samples[i].t_ns = t_ns[i];
  }
  return imu;
}

/// Cameras of one rig share their trigger: moments are smoothed once, for all of them.
void smooth_frames(std::vector<CameraData>* cameras, std::vector<std::string>* notes) {
  std::map<std::int64_t, std::int64_t> moment;
  for (const CameraData& camera : *cameras)
    for (const Frame& frame : camera.frames) moment[frame.t_ns] = 0;
  std::vector<std::int64_t> t_ns;
  for (const auto& [t, unused] : moment) t_ns.push_back(t);
  if (t_ns.empty()) return;
  const std::vector<std::int64_t> smooth = smoothed("cam0", t_ns, notes);
  for (std::size_t i = 0; i < t_ns.size(); ++i) moment[t_ns[i]] = smooth[i];
  for (CameraData& camera : *cameras)
    for (Frame& frame : camera.frames) frame.t_ns = moment[frame.t_ns];
}

/// `must_exist` where the images are the only source of tracks: then each file that the list names has to be there.
std::vector<ImageEntry> read_images(const fs::path& folder, bool must_exist) {
  std::vector<ImageEntry> images;
  CsvReader csv(folder / "data.csv", "timestamp [ns], filename", 2, 2);
  while (csv.next_row()) {
    if (csv.text(1).empty()) csv.fail("timestamp [ns], filename, found an empty filename");
    images.push_back({csv.stamp(0), folder / "data" / std::string(csv.text(1))});
    const fs::path& image = images.back().file;
    if (must_exist && !fs::exists(image)) csv.fail("an image that exists, but " + image.string() + " is missing");
  }
  return images;
}

/// Rows of one image follow each other. A stamp that changes starts a new frame; so does a track id that comes a second
/// time, because then the log holds the same stamp twice, which is a data fault for the core to count.
std::vector<Frame> read_frames(const fs::path& file) {
  std::vector<Frame> frames;
  std::unordered_set<std::uint32_t> seen;
  CsvReader csv(file, "timestamp [ns], track_id, u [px], v [px]", 4, 4);
  while (csv.next_row()) {
    const std::int64_t t_ns = csv.stamp(0);
    const TrackPoint point{csv.identifier(1), csv.number(2), csv.number(3)};
    if (frames.empty() || frames.back().t_ns != t_ns || seen.count(point.track_id) != 0) {
      frames.push_back({t_ns, {}});
      seen.clear();
    }
    seen.insert(point.track_id);
    frames.back().points.push_back(point);
  }
  return frames;
}

/// `from_images`: to be tracked again; what is in tracks.csv does not matter.
CameraData read_camera(const fs::path& folder, bool from_images) {
  if (!fs::is_directory(folder)) throw InputError(folder.string() + ": folder of the camera is missing");
  CameraData camera;
  const bool has_tracks = !from_images && fs::exists(folder / "tracks.csv");
  if (!has_tracks && !fs::exists(folder / "data.csv"))
    throw InputError(folder.string() + ": expected data.csv (images) or tracks.csv (feature tracks) in this folder");
  if (fs::exists(folder / "data.csv")) camera.images = read_images(folder, !has_tracks);
  if (has_tracks) camera.frames = read_frames(folder / "tracks.csv");
  return camera;
}

/// EuRoC's name first, then TUM-VI's.
std::vector<TruthPose> read_truth(const fs::path& mav0) {
  fs::path file = mav0 / "state_groundtruth_estimate0" / "data.csv";
  if (!fs::exists(file)) file = mav0 / "mocap0" / "data.csv";
  if (!fs::exists(file)) return {};
  std::vector<TruthPose> truth;
  CsvReader csv(file, truth_columns, 8, 64);
  while (csv.next_row()) {
    TruthPose pose;
    pose.t_ns = csv.stamp(0);
    for (std::size_t i = 0; i < 3; ++i) pose.p_GI[i] = csv.number(1 + i);
    for (std::size_t i = 0; i < 4; ++i) pose.q_GI_wxyz[i] = csv.number(4 + i);
    truth.push_back(pose);
  }
  return truth;
}

struct Span {
  std::int64_t first_ns = std::numeric_limits<std::int64_t>::max();
  std::int64_t last_ns = std::numeric_limits<std::int64_t>::min();
};

/// Smallest and largest stamp: a stamp that goes back must not hide the rest.
template <typename Stamped>
Span span_of(const std::vector<Stamped>& entries) {
  Span span;
  for (const Stamped& entry : entries) {
    span.first_ns = std::min(span.first_ns, entry.t_ns);
    span.last_ns = std::max(span.last_ns, entry.t_ns);
  }
  return span;
}

std::string seconds(const Span& span) {
  std::string text = std::to_string(static_cast<double>(span.first_ns) * 1e-9) + " s to ";
  return text + std::to_string(static_cast<double>(span.last_ns) * 1e-9) + " s";
}

void check_overlap(const Recording& recording) {
  const Span imu = span_of(recording.imu.samples);
  for (std::size_t i = 0; i < recording.cameras.size(); ++i) {
    const CameraData& data = recording.cameras[i];
    const Span camera = data.frames.empty() ? span_of(data.images) : span_of(data.frames);
    if (camera.first_ns <= imu.last_ns && imu.first_ns <= camera.last_ns) continue;
    const fs::path file =
        recording.root / "mav0" / ("cam" + std::to_string(i)) / (data.frames.empty() ? "data.csv" : "tracks.csv");
    throw InputError(file.string() + ":1: expected stamps that overlap the IMU's (" + seconds(imu) + "), found " +
                     seconds(camera));
  }
}

}  // namespace

Recording read_recording(const fs::path& root, int n_cameras, bool smooth, std::string_view replacing) {
  if (!fs::is_directory(root / "mav0"))
    throw InputError(root.string() + ": expected a recording, a folder that holds mav0/imu0 and mav0/cam0");
  check_folder(root, replacing);
  Recording recording;
  recording.root = root;
  recording.imu = read_imu(root, smooth, &recording.notes);
  for (int i = 0; i < n_cameras; ++i)
    recording.cameras.push_back(read_camera(root / "mav0" / ("cam" + std::to_string(i)), replacing == "track"));
  read_exposures(root / "mav0" / "cam0" / "exposure.csv", &recording);
  set_strays_aside(&recording);
  check_temperature(&recording.imu, true);
  if (smooth) smooth_frames(&recording.cameras, &recording.notes);
  recording.truth = read_truth(root / "mav0");
  check_overlap(recording);
  return recording;
}

std::optional<fs::path> find_real_data() {
  const char* const named = std::getenv("SEGCAL_DATA");
  const fs::path folder = named != nullptr && *named != '\0'
                              ? fs::path(named)
                              : fs::path(SEGCAL_SOURCE_DIR).parent_path() / "shared" / "data";
  if (fs::is_directory(folder)) return folder;
  return std::nullopt;
}

}  // namespace host
