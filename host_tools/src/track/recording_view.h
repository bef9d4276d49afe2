// A folder that is a recording by links to another one, and holds only the tracks itself.
#pragma once

#include <filesystem>

namespace host {

/// Makes `folder` a recording that shares everything with `source` except the tracks of each camera: IMU, ground truth,
/// image lists, images, sensor.yaml and calibration files are symbolic links. Calling it again changes nothing.
class RecordingView {
 public:
  /// Throws InputError if `folder` already holds another recording; writes nothing.
  RecordingView(const std::filesystem::path& source, const std::filesystem::path& folder, int n_cameras);

  /// Makes the folders and links. Throws InputError when the file system refuses.
  void create() const;

 private:
  void check_free() const;
  void link(const std::filesystem::path& relative) const;

  std::filesystem::path source_, folder_;
  int n_cameras_;
};

}  // namespace host
