// Files appear whole or not at all: text goes to a temporary name beside the target, then is renamed over it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

namespace host {

/// Writes `text` to `file`, creating missing folders. A reader sees the old file or the new one, never a part.
/// Throws InputError, naming the file, when the folder cannot be made or the disk refuses; nothing is left behind then.
void write_file(const std::filesystem::path& file, std::string_view text);
/// The same, and on the disk when it returns: a power cut leaves the old file or the new one too.
void write_file_synced(const std::filesystem::path& file, std::string_view text);

/// Hears of what write_file does: before a file changes, and when it has its new text.
class WriteListener {
 public:
  virtual ~WriteListener() = default;
  virtual void before_write(const std::filesystem::path& file) = 0;
  virtual void after_write(const std::filesystem::path& file, std::string_view text) = 0;
};

/// One at a time, for the files of one run (files/output_run.h); null: none. Files are written by one thread.
void listen_to_writes(WriteListener* listener);

/// Appends the shortest decimal text that reads back to the same double ("nan" for NaN, whatever its sign).
void append_number(std::string& text, double value);
void append_number(std::string& text, std::int64_t value);

/// Appends with a fixed number of decimals, for values whose last digits mean nothing (pixels, for instance).
void append_fixed(std::string& text, double value, int decimals);

/// A number's text as YAML 1.1 (PyYAML, and so Kalibr) takes it
/// for a number: 2.0e-05. Without the point it is a word there.
std::string yaml_number(std::string digits);
/// As append_number, in that form.
void append_yaml_number(std::string& text, double value);

/// Appends the line "NAME: VALUE  # UNIT".
void append_yaml_entry(std::string& text, std::string_view name, double value, std::string_view unit);

}  // namespace host
