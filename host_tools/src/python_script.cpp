#include "python_script.h"

#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>

#include "recording.h"

namespace host {
namespace {

namespace fs = std::filesystem;

constexpr int exit_cannot_execute = 127;

/// $SEGCAL_PYTHON, else the source tree's virtual environment, else python3 of the PATH.
std::string python_program() {
  if (const char* const named = std::getenv("SEGCAL_PYTHON"); named != nullptr && *named != '\0') return named;
  const fs::path in_tree = fs::path(SEGCAL_SOURCE_DIR) / ".venv" / "bin" / "python";
  return fs::exists(in_tree) ? in_tree.string() : "python3";
}

/// Runs a program and waits; its exit code, or 128 + signal. Throws InputError if it cannot be started.
int run_program(const std::vector<std::string>& arguments) {
  std::vector<char*> raw;
  for (const std::string& argument : arguments) raw.push_back(const_cast<char*>(argument.c_str()));
  raw.push_back(nullptr);
  const pid_t child = fork();
  if (child < 0) throw InputError(std::string("cannot start a process: ") + std::strerror(errno));
  if (child == 0) {
    signal(SIGPIPE, SIG_DFL);
    execvp(raw[0], raw.data());
    _exit(exit_cannot_execute);
  }
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

}  // namespace

int run_python_script(const std::string& script, const std::vector<std::string>& arguments, int negative) {
  const std::string python = python_program();
  const fs::path file = fs::path(SEGCAL_SOURCE_DIR) / "host_tools" / script;
  setenv("SEGCAL_PROGRAM_VERSION", SEGCAL_PROGRAM_VERSION, 1);
  if (!fs::exists(file)) throw InputError(file.string() + ": file is missing, this command needs the source tree");
  // -B: no compiled files beside the sources.
  std::vector<std::string> command = {python, "-B", (file.parent_path().parent_path() / "run_script.py").string(),
                                      file.string()};
  command.insert(command.end(), arguments.begin(), arguments.end());
  const int code = run_program(command);
  if (code == exit_cannot_execute) throw InputError(python + ": expected a Python 3 program; run host_tools/setup.sh");
  if (code != 0 && code != 2 && code != negative)
    throw InputError(file.string() + ": stopped with exit code " + std::to_string(code));
  return code;
}

}  // namespace host
