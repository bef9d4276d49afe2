#include "files/output_run.h"

#include <signal.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <fstream>
#include <iterator>

#include "files/sha256.h"
#include "recording.h"

namespace host {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t id_digits = 16;

/// The command line after the program's name.
std::vector<std::string> command_line() {
  std::ifstream in("/proc/self/cmdline", std::ios::binary);
  std::vector<std::string> out;
  for (std::string argument; std::getline(in, argument, '\0');) out.push_back(argument);
  if (!out.empty()) out.erase(out.begin());
  return out;
}

/// write_file's temporary names: .NAME.PID.part, of a process that is no more.
bool is_left_over_part(const fs::path& file) {
  const std::string name = file.filename().string();
  if (name.empty() || name.front() != '.' || file.extension() != ".part") return false;
  const std::string pid = fs::path(name).stem().extension().string();
  if (pid.size() < 2 || pid.find_first_not_of("0123456789", 1) != std::string::npos) return false;
  return ::kill(static_cast<pid_t>(std::strtol(pid.c_str() + 1, nullptr, 10)), 0) != 0 && errno == ESRCH;
}

void remove_left_over_parts(const fs::path& folder) {
  std::error_code error;
  std::vector<fs::path> parts;
  for (fs::recursive_directory_iterator it(folder, error), end; !error && it != end; it.increment(error))
    if (is_left_over_part(it->path())) parts.push_back(it->path());
  for (const fs::path& part : parts) fs::remove(part, error);
}

std::string id_of(const std::vector<ManifestFile>& files) {
  std::string lines;
  for (const ManifestFile& f : files) lines += f.sha256 + "  " + f.name + "\n";
  return sha256_of_text(lines).substr(0, id_digits);
}

bool contains(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

}  // namespace

void expect_output_folder(const fs::path& folder, const std::string& command, bool makes_recordings) {
  std::error_code ignored;
  if (!fs::exists(folder, ignored)) return;
  if (!fs::is_directory(folder, ignored))
    throw InputError(folder.string() + ": expected a folder to write into, found a file");
  const Manifest manifest = read_manifest(folder);
  const std::string owner = manifest.runs.empty() ? manifest.writing.command : manifest.runs.front().command;
  if (!owner.empty() && owner != command) {
    throw InputError(folder.string() + ": expected a folder of its own for `segcal " + command +
                     "`, found the files of `segcal " + owner + "`");
  }
  if (!makes_recordings && fs::exists(folder / "mav0", ignored))
    throw InputError(folder.string() + ": expected a folder of its own for `segcal " + command +
                     "`, found a recording");
}

OutputRun::OutputRun(fs::path folder, std::string command, FolderRole role)
    : folder_(fs::absolute(folder).lexically_normal()),
      command_(std::move(command)),
      role_(role),
      manifest_(read_manifest(folder_)) {
  if (manifest_.foreign)
    throw InputError((folder_ / manifest_name).string() +
                     ": expected a folder without one of another program: `segcal " + command_ + "` writes its own");
  remove_left_over_parts(folder_);
  run_.program = "segcal " SEGCAL_PROGRAM_VERSION;
  run_.command = command_;
  run_.arguments = command_line();
  if (manifest_.writing.command == command_) interrupted_ = manifest_.writing.files;
  manifest_.writing = {command_, interrupted_};
  write_manifest();
  listen_to_writes(this);
}

OutputRun::~OutputRun() { listen_to_writes(nullptr); }

std::string OutputRun::name_of(const fs::path& file) const {
  const fs::path relative = fs::absolute(file).lexically_normal().lexically_relative(folder_);
  const bool inside = !relative.empty() && *relative.begin() != "..";
  return inside && relative != manifest_name ? relative.generic_string() : "";
}

void OutputRun::write_manifest() { write_file(folder_ / manifest_name, manifest_json(manifest_)); }

void OutputRun::before_write(const fs::path& file) {
  const std::string name = name_of(file);
  if (name.empty() || contains(manifest_.writing.files, name)) return;
  manifest_.writing.files.push_back(name);
  write_manifest();
}

void OutputRun::after_write(const fs::path& file, std::string_view text) {
  const std::string name = name_of(file);
  if (name.empty()) return;
  ManifestFile entry{name, text.size(), sha256_of_text(text)};
  for (ManifestFile& f : run_.files)
    if (f.name == name) return void(f = entry);
  run_.files.push_back(entry);
}

/// Files of earlier runs that this one did not write: as they were written, or of a run that did not come to its end.
/// What a user has changed stays.
void OutputRun::remove_left_over(const std::vector<ManifestRun>& replaced,
                                 const std::vector<std::string>& interrupted) const {
  const auto written = [this](const std::string& name) {
    return std::any_of(run_.files.begin(), run_.files.end(), [&](const ManifestFile& f) { return f.name == name; });
  };
  std::error_code ignored;
  for (const ManifestRun& run : replaced)
    for (const ManifestFile& f : run.files)
      if (!written(f.name) && is_as_written(folder_, f)) fs::remove(folder_ / f.name, ignored);
  for (const std::string& name : interrupted)
    if (!written(name)) fs::remove(folder_ / name, ignored);
}

void OutputRun::finish() {
  std::vector<ManifestRun> kept, replaced;
  for (const ManifestRun& run : manifest_.runs) {
    const bool stays = role_ == FolderRole::guest && run.command != command_;
    (stays ? kept : replaced).push_back(run);
  }
  remove_left_over(replaced, interrupted_);
  run_.id = id_of(run_.files);
  kept.push_back(run_);
  manifest_.runs = kept;
  manifest_.writing = {};
  write_manifest();
}

}  // namespace host
