// The files that one run of a command writes into a folder: together, or not accepted by any reader.
//
// Each file appears whole by itself (file_output.h); a run that is killed between two of them leaves some of its own
// beside some of an earlier run. So the folder's manifest.json says first that a run is writing and which names, and
// last, in the same rename, which bytes belong together.
#pragma once

#include <filesystem>
#include <string>

#include "file_output.h"
#include "files/manifest.h"

namespace host {

/// owner: the folder is the command's own; files of its earlier run that this one did not write are removed at the end.
/// guest: the files are added to a folder that others have made, as tracks are to a recording.
enum class FolderRole { owner, guest };

/// Throws InputError if `command` cannot have `folder` as its own: it is no folder, or
/// holds a recording or the files of another command. For the beginning of a command,
/// so that no work is lost. `makes_recordings`: an earlier recording is replaced.
void expect_output_folder(const std::filesystem::path& folder, const std::string& command,
                          bool makes_recordings = false);

class OutputRun : private WriteListener {
 public:
  /// Begins: from here on all that write_file writes below `folder`
  /// belongs to this run. Removes the temporary files of killed runs.
  OutputRun(std::filesystem::path folder, std::string command, FolderRole role = FolderRole::owner);

  /// All files are written. A run that does not come here (an exception, a full disk, a kill) stays known as stopped.
  void finish();

  ~OutputRun() override;
  OutputRun(const OutputRun&) = delete;
  OutputRun& operator=(const OutputRun&) = delete;

 private:
  void before_write(const std::filesystem::path& file) override;
  void after_write(const std::filesystem::path& file, std::string_view text) override;

  /// Relative to the folder; empty: outside of it, or the manifest.
  std::string name_of(const std::filesystem::path& file) const;
  void write_manifest();
  void remove_left_over(const std::vector<ManifestRun>& replaced, const std::vector<std::string>& interrupted) const;

  std::filesystem::path folder_;
  std::string command_;
  FolderRole role_;
  Manifest manifest_;
  ManifestRun run_;
  std::vector<std::string> interrupted_;  ///< names that a stopped run of this command may have written
};

}  // namespace host
