#include "files/manifest.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "csv.h"
#include "files/sha256.h"
#include "json_numbers.h"
#include "recording.h"

namespace host {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr int format = 1;
constexpr const char* kind = "segcal output";  ///< manifest.json is a common name

/// A name that stays inside the folder: a manifest may come from anywhere.
std::string inside(const std::string& name) {
  const fs::path path(name);
  if (name.empty() || path.is_absolute()) throw InputError("expected a name inside the folder, found '" + name + "'");
  for (const fs::path& part : path)
    if (part == "..") throw InputError("expected a name inside the folder, found '" + name + "'");
  return name;
}

ManifestRun run_of(const Json& json) {
  ManifestRun run{json.at("run").get<std::string>(),
                  json.at("program").get<std::string>(),
                  json.at("command").get<std::string>(),
                  json.at("arguments").get<std::vector<std::string>>(),
                  {}};
  for (const Json& f : json.at("files"))
    run.files.push_back({inside(f.at("name").get<std::string>()), whole_number<std::uintmax_t>(f.at("bytes")),
                         f.at("sha256").get<std::string>()});
  return run;
}

Json json_of(const ManifestRun& run) {
  Json files = Json::array();
  for (const ManifestFile& f : run.files) files.push_back({{"name", f.name}, {"bytes", f.bytes}, {"sha256", f.sha256}});
  return {{"run", run.id},
          {"program", run.program},
          {"command", run.command},
          {"arguments", run.arguments},
          {"files", files}};
}

[[noreturn]] void refuse_stopped(const fs::path& folder, const Manifest& manifest) {
  throw InputError(folder.string() + ": expected all files of one run, but `segcal " + manifest.writing.command +
                   "` was stopped while it wrote them (" + manifest_name + "); run it again");
}

[[noreturn]] void refuse_changed(const fs::path& folder, const ManifestRun& run, const ManifestFile& file) {
  throw InputError((folder / file.name).string() + ": expected the file that `segcal " + run.command +
                   "` wrote with the others of this folder, found another one; run it again, or remove " +
                   (folder / manifest_name).string() + " if you changed the file yourself");
}

/// A stopped run refuses a file that it may have written, and one
/// of its own command: report and export refuse the folder as well.
void check_as_listed(const fs::path& folder, const Manifest& manifest, const std::string& name) {
  const auto& writing = manifest.writing;
  if (std::find(writing.files.begin(), writing.files.end(), name) != writing.files.end())
    refuse_stopped(folder, manifest);
  for (const ManifestRun& run : manifest.runs) {
    for (const ManifestFile& file : run.files) {
      if (file.name != name) continue;
      if (run.command == writing.command) refuse_stopped(folder, manifest);
      if (!is_as_written(folder, file)) refuse_changed(folder, run, file);
    }
  }
}

constexpr int deepest = 3;  ///< mav0/cam0/sensor.yaml: no name that segcal lists has more parts

void check_in_folders_above(const fs::path& file) {
  fs::path folder = file.parent_path();
  for (int up = 0; up < deepest; ++up, folder = folder.parent_path()) {
    Manifest manifest;
    try {
      manifest = read_manifest(folder);
    } catch (const InputError&) {
      if (up == 0) throw;  // further up, a file of this name that nobody can read is not about our file
    }
    check_as_listed(folder, manifest, file.lexically_relative(folder).generic_string());
  }
}

}  // namespace

Manifest read_manifest(const fs::path& folder) {
  const fs::path file = folder / manifest_name;
  std::error_code ignored;
  Manifest out;
  if (!fs::exists(file, ignored)) return out;
  const std::string text = read_file(file);
  try {
    const Json json = Json::parse(text);
    out.foreign = !json.is_object() || json.value("kind", Json()) != kind;
    if (out.foreign) return out;
    if (whole_number<int>(json.at("format")) != format) throw InputError("expected format " + std::to_string(format));
    for (const Json& run : json.at("runs")) out.runs.push_back(run_of(run));
    if (!json.contains("writing")) return out;
    out.writing.command = json["writing"].at("command").get<std::string>();
    for (const Json& name : json["writing"].at("files")) out.writing.files.push_back(inside(name.get<std::string>()));
  } catch (const std::exception& error) {
    throw InputError(file.string() + ": expected the list of files that segcal writes: " + error.what());
  }
  return out;
}

std::string manifest_json(const Manifest& manifest) {
  Json json = {{"format", format}, {"kind", kind}, {"runs", Json::array()}};
  for (const ManifestRun& run : manifest.runs) json["runs"].push_back(json_of(run));
  if (!manifest.writing.command.empty())
    json["writing"] = {{"command", manifest.writing.command}, {"files", manifest.writing.files}};
  return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";  // a file name need not be UTF-8
}

bool is_as_written(const fs::path& folder, const ManifestFile& file) {
  const fs::path path = folder / file.name;
  std::error_code error;
  if (!fs::is_regular_file(path, error) || fs::file_size(path, error) != file.bytes || error) return false;
  return sha256_of_file(path) == file.sha256;
}

void check_folder(const fs::path& folder, std::string_view replacing) {
  const Manifest manifest = read_manifest(folder);
  if (!manifest.writing.command.empty() && manifest.writing.command != replacing) refuse_stopped(folder, manifest);
  std::error_code ignored;
  for (const ManifestRun& run : manifest.runs) {
    if (run.command == replacing) continue;
    for (const ManifestFile& file : run.files)
      if (fs::exists(folder / file.name, ignored) && !is_as_written(folder, file)) refuse_changed(folder, run, file);
  }
}

void check_file(const fs::path& file) {
  std::error_code ignored;
  const fs::path here = fs::absolute(file).lexically_normal(), target = fs::weakly_canonical(file, ignored);
  check_in_folders_above(here);
  if (!target.empty() && target != here) check_in_folders_above(target);  // a link into a folder of ours, or out of one
}

}  // namespace host
