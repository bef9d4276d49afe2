// The file of `segcal replay --state` (docs/formats.md): a device's stored state and the logs that it has seen.
//
// The flash that a device stores to is held in memory and written as a whole, under another name, synced and renamed:
// whatever stops a run, the file is that of the run before or that of this one.
#pragma once

#include <filesystem>
#include <vector>

#include "state/flash_image.h"

namespace host {

/// A log that went into a state.
struct SeenLog {
  std::string name, sha256;  ///< as in result.json
  std::string imu_sha256;    ///< of its rotation rates alone: the same motion, however its images were tracked
};

class StateFile {
 public:
  /// Reads the file, or takes its place if there is none, and locks it until the end. Throws InputError, in one line,
  /// if it is no state file, is damaged, of a newer format, in use by another run, or could not be replaced.
  explicit StateFile(const std::filesystem::path& file);
  ~StateFile();
  StateFile(const StateFile&) = delete;
  StateFile& operator=(const StateFile&) = delete;

  const std::filesystem::path& path() const { return path_; }
  bool is_new() const { return profile.empty(); }
  /// Replaces the file by what is in here. Throws InputError if the disk refuses; the file is then as it was.
  void write();

  std::string profile;        ///< that the state is of; empty: nothing is stored yet
  std::vector<SeenLog> logs;  ///< oldest first
  FlashImage flash;

 private:
  void lock();
  void release();
  void read();
  void remove_left_over() const;

  std::filesystem::path path_;  ///< where links lead to
  int descriptor_ = -1;         ///< holds the lock
  bool made_ = false;           ///< the file is only the place that this run took
};

}  // namespace host
