// A folder of files for fuzz targets of readers, and the one way in which a reader may refuse a file.
#pragma once

#include <unistd.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include "recording.h"

class FuzzFolder {
 public:
  FuzzFolder() : path_(std::filesystem::temp_directory_path() / ("segcal_fuzz_" + std::to_string(::getpid()))) {
    std::filesystem::create_directories(path_);
  }
  ~FuzzFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  const std::filesystem::path& path() const { return path_; }

  std::filesystem::path put(const std::string& name, const std::string& text) const {
    const std::filesystem::path file = path_ / name;
    std::filesystem::create_directories(file.parent_path());
    std::ofstream(file, std::ios::binary) << text;
    return file;
  }

 private:
  std::filesystem::path path_;
};

/// Runs a reader. Refusing is an InputError with a sentence;
/// any other exception is a finding, because it names no file.
template <class Reader>
bool reads(const Reader& reader) {
  try {
    reader();
    return true;
  } catch (const host::InputError& error) {
    if (*error.what() != '\0') return false;
    std::printf("an InputError without words\n");
  } catch (const std::exception& error) {
    std::printf("not an InputError: %s\n", error.what());
  }
  std::fflush(stdout);
  std::abort();
}
