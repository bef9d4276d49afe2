#include "state/state_file.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <nlohmann/json.hpp>

#include "csv.h"
#include "file_output.h"
#include "files/sha256.h"
#include "recording.h"

namespace host {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

const std::string kMagic = "segcal state 1 ";  // then 64 digits: SHA-256 of all that follows the line

[[noreturn]] void refuse(const fs::path& file, const std::string& why) { throw InputError(file.string() + ": " + why); }

Json logs_json(const std::vector<SeenLog>& logs) {
  Json json = Json::array();
  for (const SeenLog& log : logs)
    json.push_back({{"name", log.name}, {"sha256", log.sha256}, {"imu_sha256", log.imu_sha256}});
  return json;
}

fs::path target_of(const fs::path& file) {
  std::error_code error;
  const fs::path target = fs::weakly_canonical(file, error);
  return error ? file : target;
}

}  // namespace

StateFile::StateFile(const fs::path& file) : path_(target_of(file)) {
  std::error_code ignored;
  if (fs::exists(path_, ignored) && !fs::is_regular_file(path_, ignored))
    refuse(file, "expected a state file of segcal replay --state, found no regular file");
  try {
    lock();
    remove_left_over();
    read();
  } catch (...) {
    release();
    throw;
  }
}

StateFile::~StateFile() { release(); }

void StateFile::release() {
  if (descriptor_ < 0) return;
  std::error_code ignored;
  if (made_) fs::remove(path_, ignored);
  ::close(descriptor_);  // and with it the lock
  descriptor_ = -1;
}

/// The one who has locked the file that has the name now may replace it.
void StateFile::lock() {
  const fs::path folder = path_.has_parent_path() ? path_.parent_path() : fs::path(".");
  std::error_code error;
  fs::create_directories(folder, error);
  for (;;) {
    descriptor_ = ::open(path_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
    if (descriptor_ < 0)
      refuse(path_, std::string("cannot be opened for reading and writing: ") + std::strerror(errno));
    if (::flock(descriptor_, LOCK_EX | LOCK_NB) != 0) {
      const int why = errno;
      ::close(descriptor_);
      descriptor_ = -1;
      refuse(path_, why == EWOULDBLOCK
                        ? "in use by another run of segcal replay --state; expected one run at a time on it"
                        : std::string("cannot be locked: ") + std::strerror(why));
    }
    struct stat held {
    }, named{};
    if (::fstat(descriptor_, &held) == 0 && ::stat(path_.c_str(), &named) == 0 && held.st_ino == named.st_ino &&
        held.st_dev == named.st_dev) {
      made_ = held.st_size == 0;
      break;
    }
    ::close(descriptor_);  // replaced or removed in between by the run that held it
    descriptor_ = -1;
  }
  if (::access(folder.c_str(), W_OK) != 0)
    refuse(path_, std::string("its folder cannot be written to: ") + std::strerror(errno));
}

/// Temporary files of runs that were killed; none is in use, since the lock is ours.
void StateFile::remove_left_over() const {
  const std::string begin = "." + path_.filename().string() + ".";
  std::error_code error;
  for (const fs::directory_entry& entry :
       fs::directory_iterator(path_.parent_path().empty() ? "." : path_.parent_path(), error)) {
    const std::string name = entry.path().filename().string();
    if (name.rfind(begin, 0) != 0 || entry.path().extension() != ".part") continue;
    std::error_code ignored;
    fs::remove(entry.path(), ignored);
  }
}

void StateFile::read() {
  if (made_) return;
  const std::string text = read_file(path_);
  const std::size_t line = kMagic.size() + 64;
  if (text.compare(0, kMagic.size(), kMagic) != 0) {
    refuse(path_, text.rfind("segcal state ", 0) == 0
                      ? "expected format 1, found that of a newer segcal"
                      : "expected a state file of segcal replay --state, found another file");
  }
  if (text.size() <= line || text[line] != '\n' ||
      sha256_of_text(std::string_view(text).substr(line + 1)) != text.substr(kMagic.size(), 64)) {
    refuse(path_,
           "damaged: its bytes are not those that segcal replay --state wrote; expected a copy of it that is whole");
  }
  const std::size_t end = text.find('\n', line + 1);
  const Json json = Json::parse(text.substr(line + 1, end - line - 1));  // as write() wrote it, by the digits
  profile = json.at("profile");
  for (const Json& log : json.at("logs")) logs.push_back({log.at("name"), log.at("sha256"), log.at("imu_sha256")});
  flash.bytes = text.substr(end + 1);
}

void StateFile::write() {
  const Json json = {{"profile", profile}, {"library_version", SEGCAL_PROGRAM_VERSION}, {"logs", logs_json(logs)}};
  const std::string rest = json.dump() + "\n" + flash.bytes;
  write_file_synced(path_, kMagic + sha256_of_text(rest) + "\n" + rest);
  made_ = false;
}

}  // namespace host
