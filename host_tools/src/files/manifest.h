// manifest.json: which files of a folder belong together
// (docs/formats.md). files/output_run.h writes it, readers check it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace host {

struct ManifestFile {
  std::string name;  ///< relative to the folder, with '/'
  std::uintmax_t bytes = 0;
  std::string sha256;
};

/// What one run of the program left in the folder.
struct ManifestRun {
  std::string id;       ///< 16 digits that follow from the files: equal runs have equal ids
  std::string program;  ///< "segcal 1.0.0"
  std::string command;  ///< "replay"
  std::vector<std::string> arguments;
  std::vector<ManifestFile> files;
};

/// A run that has begun to write and did not say that it is done.
struct ManifestWriting {
  std::string command;  ///< empty: none
  std::vector<std::string> files;
};

struct Manifest {
  bool foreign = false;  ///< a manifest.json of another program: the rest is empty
  std::vector<ManifestRun> runs;
  ManifestWriting writing;
};

constexpr const char* manifest_name = "manifest.json";

/// Of a folder without one: empty. Throws InputError if it cannot be read.
Manifest read_manifest(const std::filesystem::path& folder);

std::string manifest_json(const Manifest& manifest);

/// True if the file is there and has the bytes that the manifest says.
bool is_as_written(const std::filesystem::path& folder, const ManifestFile& file);

/// Throws InputError if the folder's manifest tells of a run that was stopped while it wrote, or of a file that is
/// another one now. A folder without a manifest passes, made by hand or by other programs, and so do files that were
/// removed. `replacing`: the command that is about to replace its own files; these are not looked at.
void check_folder(const std::filesystem::path& folder, std::string_view replacing = {});

/// The same for one file that is read by its own path, as --calib's: looks for a manifest that lists it in its folder
/// and in those above. Files that pass, of one folder, belong together.
void check_file(const std::filesystem::path& file);

}  // namespace host
