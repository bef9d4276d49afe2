#include "file_output.h"

#include <fcntl.h>
#include <unistd.h>

#include <charconv>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <system_error>

#include "recording.h"

namespace host {
namespace {

namespace fs = std::filesystem;

WriteListener* listener = nullptr;

/// A name in the same folder (rename does not cross file systems); the process id keeps two runs apart.
fs::path temporary_name(const fs::path& file) {
  return file.parent_path() / ("." + file.filename().string() + "." + std::to_string(::getpid()) + ".part");
}

[[noreturn]] void refuse_write(const fs::path& file, const std::string& why) {
  throw InputError(file.string() + ": cannot be written: " + why);
}

void make_folder_of(const fs::path& file) {
  const fs::path folder = file.parent_path();
  if (folder.empty()) return;
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) refuse_write(file, error.message());
}

/// Waits until the disk has a file or a folder.
bool sync(const fs::path& path) {
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) return false;
  const bool done = ::fsync(descriptor) == 0;
  ::close(descriptor);
  return done;
}

void write(const fs::path& file, std::string_view text, bool synced) {
  make_folder_of(file);
  if (listener) listener->before_write(file);
  const fs::path part = temporary_name(file);
  std::ofstream stream(part, std::ios::binary | std::ios::trunc);
  stream.write(text.data(), static_cast<std::streamsize>(text.size()));
  stream.close();

  std::error_code error;
  if (!stream || (synced && !sync(part))) {
    fs::remove(part, error);
    refuse_write(file, "the folder is read-only or the disk is full");
  }
  fs::rename(part, file, error);
  if (error) {
    std::error_code ignored;
    fs::remove(part, ignored);
    refuse_write(file, error.message());
  }
  if (synced) sync(file.has_parent_path() ? file.parent_path() : fs::path("."));
  if (listener) listener->after_write(file, text);
}

}  // namespace

void listen_to_writes(WriteListener* new_listener) { listener = new_listener; }

void write_file(const fs::path& file, std::string_view text) { write(file, text, false); }
void write_file_synced(const fs::path& file, std::string_view text) { write(file, text, true); }

void append_number(std::string& text, double value) {
  if (std::isnan(value)) {
    text += "nan";
    return;
  }
  char digits[40];
  const auto end = std::to_chars(digits, digits + sizeof digits, value).ptr;
  text.append(digits, end);
}

void append_number(std::string& text, std::int64_t value) {
  char digits[24];
  const auto end = std::to_chars(digits, digits + sizeof digits, value).ptr;
  text.append(digits, end);
}

void append_fixed(std::string& text, double value, int decimals) {
  if (!std::isfinite(value)) return append_number(text, value);
  char digits[352];  // the longest double has 309 digits before the point
  const int length = std::snprintf(digits, sizeof digits, "%.*f", decimals, value);
  text.append(digits, static_cast<std::size_t>(length));
}

std::string yaml_number(std::string digits) {
  const std::size_t exponent = digits.find('e');
  if (exponent != std::string::npos && digits.find('.') == std::string::npos) digits.insert(exponent, ".0");
  return digits;
}

void append_yaml_number(std::string& text, double value) {
  std::string digits;
  append_number(digits, value);
  text += yaml_number(digits);
}

void append_yaml_entry(std::string& text, std::string_view name, double value, std::string_view unit) {
  text += name;
  text += ": ";
  append_yaml_number(text, value);
  text += "  # ";
  text += unit;
  text += '\n';
}

}  // namespace host
