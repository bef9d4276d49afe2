#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <iostream>
#include <map>

#include "csv.h"
#include "experiments/experiment.h"
#include "file_output.h"
#include "recording.h"

namespace host::experiments {
namespace {

namespace fs = std::filesystem;

fs::path file_of(const fs::path& dir, const Cell& cell) { return dir / "cells" / (cell.name + ".json"); }

/// The result on disk; null if there is none, if it is of other parameters, or if it cannot be read.
Json stored(const fs::path& file, const Json& parameters) {
  std::error_code ignored;
  if (!fs::exists(file, ignored)) return nullptr;
  const Json json = Json::parse(std::ifstream(file), nullptr, false);
  const bool usable = json.is_object() && json.value("format", 0) == 1 && json.contains("result") &&
                      json.value("parameters", Json()) == parameters;
  return usable ? json["result"] : Json(nullptr);
}

/// In the child: the exit code is all that the parent hears, the rest is in the file.
[[noreturn]] void run_in_child(const Experiment& experiment, const Cell& cell, const fs::path& file) {
  int code = 1;
  try {
    const Json json = {{"format", 1},
                       {"experiment", experiment.name},
                       {"parameters", cell.parameters},
                       {"result", experiment.run(cell.parameters)}};
    write_file(file, json.dump(1) + "\n");
    code = 0;
  } catch (const std::exception& error) {
    std::cerr << "\n" << cell.name << ": " << error.what() << std::endl;
  }
  _exit(code);
}

/// One process per cell: the core's memory is fresh in each, and a crash takes one cell only.
class Workers {
 public:
  Workers(const Experiment& experiment, const fs::path& dir) : experiment_(experiment), dir_(dir) {}

  void start(const Cell& cell) {
    std::cout.flush();
    std::cerr.flush();
    const pid_t child = fork();
    if (child < 0) throw InputError(std::string("cannot start a process: ") + std::strerror(errno));
    if (child == 0) run_in_child(experiment_, cell, file_of(dir_, cell));
    running_[child] = cell.name;
  }

  void wait_for_one() {
    int status = 0;
    const pid_t child = waitpid(-1, &status, 0);
    if (child < 0 && errno == EINTR) return;
    const auto it = running_.find(child);
    if (it == running_.end()) return;
    if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) failed.push_back(it->second);
    running_.erase(it);
  }

  int running() const { return static_cast<int>(running_.size()); }
  std::vector<std::string> failed;

 private:
  const Experiment& experiment_;
  fs::path dir_;
  std::map<pid_t, std::string> running_;
};

void show_progress(const char* name, std::size_t done, std::size_t all, std::size_t found) {
  const bool terminal = isatty(STDERR_FILENO) != 0;
  if (!terminal && done != all && done % 10 != 0) return;
  std::fprintf(stderr, "%s%s: %zu of %zu cells, %zu were there%s", terminal ? "\r" : "", name, done, all, found,
               !terminal || done == all ? "\n" : "");
}

}  // namespace

std::vector<CellResult> run_cells(const Experiment& experiment, const std::vector<Cell>& cells, const fs::path& dir,
                                  int jobs) {
  std::vector<const Cell*> open;
  for (const Cell& cell : cells) {
    if (stored(file_of(dir, cell), cell.parameters).is_null()) open.push_back(&cell);
  }
  const std::size_t found = cells.size() - open.size();
  Workers workers(experiment, dir);
  const int most = experiment.alone ? 1 : jobs;
  if (open.empty()) show_progress(experiment.name, found, cells.size(), found);
  for (std::size_t next = 0, done = 0; done < open.size();) {
    while (next < open.size() && workers.running() < most) workers.start(*open[next++]);
    const int before = workers.running();
    workers.wait_for_one();
    done += static_cast<std::size_t>(before - workers.running());
    show_progress(experiment.name, found + done, cells.size(), found);
  }
  if (!workers.failed.empty()) {
    throw InputError(std::to_string(workers.failed.size()) + " cells failed, the first is " + workers.failed.front() +
                     "; the same command tries them again");
  }
  std::vector<CellResult> out;
  for (const Cell& cell : cells) {
    out.push_back({cell.parameters, stored(file_of(dir, cell), cell.parameters)});
    if (out.back().result.is_null())
      throw InputError(file_of(dir, cell).string() + ": expected the result of this cell");
  }
  return out;
}

}  // namespace host::experiments
