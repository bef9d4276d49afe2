// A strict reader of comma-separated numbers: each fault is an InputError that names file, line and what was expected.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace host {

/// Reads one file from top to bottom. Lines that start with '#'
/// and empty lines are skipped; \r\n ends a line as \n does.
///
///     CsvReader csv(file, "timestamp [ns], track_id, u [px], v [px]", 4, 4);
///     while (csv.next_row()) { t = csv.integer(0); u = csv.number(2); }
class CsvReader {
 public:
  /// `columns` describes a row in error messages. Throws InputError if the file is missing or unreadable.
  CsvReader(const std::filesystem::path& file, std::string columns, std::size_t min_columns, std::size_t max_columns);

  /// Moves to the next row of data; false at the end of the file. Throws InputError when the row
  /// has another number of columns than promised or than the first row, or when the file ended
  /// and held no row at all. A last line that does not end with a newline is left out, whatever
  /// it holds, and a line on stderr says so: the writer may have been stopped within a number.
  bool next_row();

  std::size_t columns() const { return fields_.size(); }
  std::size_t line() const { return line_; }

  /// The field as text, without surrounding blanks.
  std::string_view text(std::size_t column) const { return fields_[column]; }
  /// A floating-point number; "nan" and "inf" are numbers (a data fault, not a format fault).
  double number(std::size_t column) const;
  /// A whole number that fits int64.
  std::int64_t integer(std::size_t column) const;
  /// A stamp, ns: a whole number within +-2^62 (146 years), so that the difference of any two is one too.
  std::int64_t stamp(std::size_t column) const;
  /// A whole number from 0 to 2^32 - 1.
  std::uint32_t identifier(std::size_t column) const;

  /// Throws InputError "FILE:LINE: expected EXPECTED" for the current row.
  [[noreturn]] void fail(const std::string& expected) const;

 private:
  bool next_line();
  void split();
  bool is_cut() const;
  bool leave_out_cut_line();
  [[noreturn]] void fail_field(std::size_t column, const char* expected) const;

  std::filesystem::path file_;
  std::string description_;
  std::size_t min_columns_, max_columns_;
  std::string content_;
  std::size_t position_ = 0;
  std::string_view row_;
  std::vector<std::string_view> fields_;
  std::size_t line_ = 0;
  std::size_t rows_ = 0;
};

/// Throws InputError if the file is missing, or is a folder, a pipe or a device: reading these would wait for ever.
void expect_regular_file(const std::filesystem::path& file);

/// The whole file as text. Throws InputError if it is missing, a folder, unreadable or empty.
std::string read_file(const std::filesystem::path& file);

}  // namespace host
