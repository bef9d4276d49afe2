// `segcal track`: images of a recording to feature tracks.
#include <unistd.h>

#include <iostream>
#include <map>
#include <nlohmann/json.hpp>

#include "../calibration_file.h"
#include "../commands.h"
#include "../csv.h"
#include "../files/output_run.h"
#include "../recording.h"
#include "feature_tracker.h"
#include "image_file.h"
#include "lens_search.h"
#include "recording_view.h"
#include "stereo_matcher.h"
#include "track_statistics.h"

namespace host {
namespace {

namespace fs = std::filesystem;

constexpr const char* command_name = "track";
constexpr const char* description =
    "Finds corners in the images of a recording and follows them: REC/mav0/camN/tracks.csv";

constexpr const char* details =
    R"(Where REC is read-only, --out FOLDER makes FOLDER a recording that links to REC and holds the tracks; replay FOLDER then. Changes
to FOLDER's IMU or images change REC.
Identifiers are those of the whole rig: the same number in two cameras is the same corner. Corners of cam0 are looked for
in the other cameras' images of the same moment, and checked by an epipolar geometry that needs no calibration.
The calibration (--calib, else REC/camchain-imucam.yaml, else camN/sensor.yaml) says how large images are, and where to look
for a corner of cam0 in another camera: tracks of a single camera do not depend on it. Outliers are what disagrees with the
other corners about the motion from one image to the next; how much the lens bends lines is found from forty pairs of images.)";

struct TrackSettings {
  std::string recording, calibration, out;
  int n_cameras = 0;  // 0: all
  bool json = false, no_equalise = false;
  TrackerOptions tracker;
};

void show_progress(std::size_t done, std::size_t total, const std::vector<FeatureTracker>& trackers) {
  if (done % 100 != 0 && done != total) return;
  std::cerr << done << " of " << total << " moments, tracks:";
  for (const FeatureTracker& tracker : trackers) std::cerr << ' ' << tracker.tracks().size();
  std::cerr << '\n';
}

/// The images of one moment, by camera; null where a camera has none.
using Moment = std::vector<const ImageEntry*>;

/// In the order of their stamps.
std::map<std::int64_t, Moment> moments_of(const Recording& recording) {
  std::map<std::int64_t, Moment> moments;
  const std::size_t n = recording.cameras.size();
  for (std::size_t c = 0; c < n; ++c) {
    for (const ImageEntry& entry : recording.cameras[c].images) {
      Moment& moment = moments[entry.t_ns];
      moment.resize(n, nullptr);
      moment[c] = &entry;
    }
  }
  return moments;
}

/// The first camera leads: the others look for its new corners first, and fill up with corners of their own.
class RigTracker {
 public:
  RigTracker(const Recording& recording, const Calibration& calibration, const TrackerOptions& options)
      : matchers_(calibration.cameras.size(), StereoMatcher(options)), frames(calibration.cameras.size()) {
    const auto next_id = std::make_shared<std::uint32_t>(0);
    for (std::size_t i = 0; i < calibration.cameras.size(); ++i) {
      const CameraCalibration& camera = calibration.cameras[i];
      const double bend = find_bend(recording.cameras[i].images, camera, options);
      std::cerr << "cam" << i << ": bend of the lens " << bend << " (0: pinhole, -1.2: fisheye of 180 deg)\n";
      trackers.emplace_back(camera, bend, options, next_id);
    }
  }

  void next(std::int64_t t_ns, const Moment& moment) {
    for (std::size_t c = 0; c < trackers.size(); ++c) {
      if (!moment[c]) continue;
      trackers[c].follow(read_image(moment[c]->file, trackers[c].camera()));
      if (c > 0 && moment[0]) matchers_[c].match(trackers[0], trackers[c]);
      trackers[c].add_corners();
      frames[c].push_back({t_ns, trackers[c].points()});
    }
  }

 private:
  std::vector<StereoMatcher> matchers_;

 public:
  std::vector<FeatureTracker> trackers;
  std::vector<std::vector<Frame>> frames;
};

fs::path tracks_file(const fs::path& root, int camera) {
  return root / "mav0" / ("cam" + std::to_string(camera)) / "tracks.csv";
}

/// Known before the work starts, so that minutes of tracking are not lost to a read-only folder.
void check_writable(const fs::path& root, int n_cameras) {
  for (int i = 0; i < n_cameras; ++i) {
    const fs::path folder = tracks_file(root, i).parent_path();
    if (fs::exists(folder) && ::access(folder.c_str(), W_OK) != 0)
      throw InputError(folder.string() + ": folder is read-only: use --out FOLDER");
  }
}

std::vector<std::vector<Frame>> track_all(const Recording& recording, const TrackSettings& settings) {
  const Calibration calibration = find_calibration(recording.root, settings.calibration, settings.n_cameras);
  for (int i = 0; i < settings.n_cameras; ++i) {
    if (recording.cameras[static_cast<std::size_t>(i)].images.empty())
      throw InputError((tracks_file(recording.root, i).parent_path() / "data.csv").string() +
                       ": file is missing: expected the list of images");
  }
  const std::map<std::int64_t, Moment> moments = moments_of(recording);
  RigTracker rig(recording, calibration, settings.tracker);
  std::size_t done = 0;
  for (const auto& [t_ns, moment] : moments) {
    rig.next(t_ns, moment);
    show_progress(++done, moments.size(), rig.trackers);
  }
  return rig.frames;
}

/// Cameras of the recording that have images and a calibration.
int cameras_present(const TrackSettings& settings) {
  const fs::path mav0 = fs::path(settings.recording) / "mav0";
  int n = 1;
  while (n < 8 && fs::exists(mav0 / ("cam" + std::to_string(n)) / "data.csv")) ++n;
  while (n > 1) {
    try {
      find_calibration(settings.recording, settings.calibration, n);
      break;
    } catch (const InputError& error) {
      --n;
      std::cerr << "cam" << n << " is left out, it has no calibration: " << error.what() << '\n';
    }
  }
  return n;
}

void report(const std::vector<std::vector<Frame>>& tracks, const TrackSettings& settings) {
  nlohmann::json result = nlohmann::json::array();
  const fs::path root = settings.out;
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    result.push_back(track_statistics(tracks[i]));
    result.back()["file"] = tracks_file(root, static_cast<int>(i)).string();
  }
  if (settings.json) {
    std::cout << nlohmann::json{{"cameras", result}}.dump(2) << '\n';
    return;
  }
  for (const nlohmann::json& camera : result)
    std::cout << camera["file"].get<std::string>() << ": " << camera["tracks"] << " tracks in " << camera["images"]
              << " images, " << static_cast<int>(camera["tracks_per_image_mean"].get<double>() + 0.5)
              << " per image, half of the points in tracks of " << camera["track_length_of_half_the_points"]
              << " images or more\n";
}

void finish(const std::vector<std::vector<Frame>>& tracks, const TrackSettings& settings) {
  OutputRun files(settings.out, command_name, FolderRole::guest);
  for (std::size_t i = 0; i < tracks.size(); ++i)
    write_tracks(tracks_file(settings.out, static_cast<int>(i)), tracks[i]);
  files.finish();
  report(tracks, settings);
}

void run(TrackSettings settings) {
  cv::setNumThreads(1);  // one image is too small a task to share out, and the result must not depend on the machine
  if (settings.n_cameras == 0) settings.n_cameras = cameras_present(settings);
  const Recording recording = read_recording(settings.recording, settings.n_cameras, false, command_name);
  const bool in_place =
      settings.out.empty() || (fs::exists(settings.out) && fs::equivalent(settings.out, recording.root));
  if (in_place) {
    settings.out = settings.recording;
    check_writable(recording.root, settings.n_cameras);
    return finish(track_all(recording, settings), settings);
  }
  const RecordingView view(recording.root, settings.out, settings.n_cameras);
  const auto tracks = track_all(recording, settings);
  view.create();
  finish(tracks, settings);
}

}  // namespace

void add_track_command(CLI::App& app, int& exit_code) {
  auto settings = std::make_shared<TrackSettings>();
  CLI::App* const command = app.add_subcommand(command_name, description);
  TrackerOptions& tracker = settings->tracker;
  command->add_option("REC", settings->recording, "recording with images, EuRoC's folder layout")->required();
  command->add_option("--calib", settings->calibration, "calibration in Kalibr's layout (camchain-imucam.yaml)");
  command->add_option("--out", settings->out,
                      "folder to make a recording with the tracks, instead of writing into REC");
  command
      ->add_option("--cameras", settings->n_cameras,
                   "number of cameras, cam0 first (default: all that have images and a calibration)")
      ->check(CLI::Range(1, 8));
  command->add_option("--max-tracks", tracker.corners.max_tracks, "corners to keep in each image")
      ->check(CLI::Range(8, 2000))
      ->capture_default_str();
  command->add_option("--min-distance", tracker.corners.min_distance_px, "between corners, px")
      ->check(CLI::Range(3, 200))
      ->capture_default_str();
  command->add_option("--window", tracker.window_px, "side of the matched patch, px")
      ->check(CLI::Range(7, 51))
      ->capture_default_str();
  command
      ->add_option("--max-epipolar", tracker.max_epipolar_px,
                   "outliers are farther than 2.5 robust sigmas from their epipolar lines, at least 0.2 px, and at "
                   "most this, px")
      ->check(CLI::Range(0.1, 20.0))
      ->capture_default_str();
  command->add_flag("--no-equalise", settings->no_equalise,
                    "track in the original grey values, without local contrast (CLAHE)");
  command->add_flag("--json", settings->json, "print the statistics as JSON");
  command->footer(details);
  command->callback([settings, &exit_code] {
    settings->tracker.equalise = !settings->no_equalise;
    run(*settings);
    exit_code = 0;
  });
}

}  // namespace host
