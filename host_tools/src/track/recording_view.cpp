#include "recording_view.h"

#include <string>

#include "../recording.h"

namespace host {
namespace {

namespace fs = std::filesystem;

constexpr const char* shared_entries[] = {
    "mav0/imu0", "mav0/state_groundtruth_estimate0", "mav0/mocap0", "camchain-imucam.yaml", "imu.yaml", "dso"};
constexpr const char* shared_camera_entries[] = {"data.csv", "exposure.csv", "sensor.yaml", "data"};

}  // namespace

RecordingView::RecordingView(const fs::path& source, const fs::path& folder, int n_cameras)
    : source_(fs::canonical(source)), folder_(folder), n_cameras_(n_cameras) {
  check_free();
}

/// A folder with an IMU log of its own is somebody's recording: adding tracks from other images would spoil it.
void RecordingView::check_free() const {
  const fs::path imu = folder_ / "mav0" / "imu0";
  if (!fs::exists(imu) || fs::equivalent(imu, source_ / "mav0" / "imu0")) return;
  throw InputError(folder_.string() + ": expected a new or empty folder, found another recording");
}

void RecordingView::create() const {
  try {
    for (const char* const entry : shared_entries) link(entry);
    for (int i = 0; i < n_cameras_; ++i)
      for (const char* const entry : shared_camera_entries)
        link(fs::path("mav0") / ("cam" + std::to_string(i)) / entry);
  } catch (const fs::filesystem_error& error) {
    throw InputError(folder_.string() + ": cannot be written: " + error.code().message());
  }
}

void RecordingView::link(const fs::path& relative) const {
  const fs::path target = source_ / relative, name = folder_ / relative;
  if (!fs::exists(target)) return;
  fs::create_directories(name.parent_path());
  if (fs::is_symlink(name)) fs::remove(name);
  if (!fs::exists(name)) fs::create_symlink(target, name);
}

}  // namespace host
