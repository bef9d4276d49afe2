#include "csv.h"

#include <charconv>
#include <fstream>
#include <iostream>
#include <iterator>
#include <limits>

#include "recording.h"

namespace host {
namespace {

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view blanks = " \t\r";
  const std::size_t first = text.find_first_not_of(blanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(blanks) - first + 1);
}

/// The whole field must be the number: "1.5x" and "" are refused.
/// A leading '+' is allowed, which from_chars does not know.
template <typename Number>
bool parse(std::string_view field, Number& value) {
  if (field.size() > 1 && field.front() == '+' && field[1] != '-') field.remove_prefix(1);
  const char* const end = field.data() + field.size();
  const auto result = std::from_chars(field.data(), end, value);
  return result.ec == std::errc() && result.ptr == end;
}

}  // namespace

void expect_regular_file(const std::filesystem::path& file) {
  std::error_code ignored;
  const std::filesystem::file_status status = std::filesystem::status(file, ignored);
  if (!std::filesystem::exists(status)) throw InputError(file.string() + ": file is missing");
  if (std::filesystem::is_directory(status)) throw InputError(file.string() + ": expected a file, found a folder");
  if (!std::filesystem::is_regular_file(status))
    throw InputError(file.string() + ": expected a regular file, found a pipe or a device");
}

std::string read_file(const std::filesystem::path& file) {
  expect_regular_file(file);
  std::ifstream stream(file, std::ios::binary);
  if (!stream) throw InputError(file.string() + ": file cannot be opened");
  std::string content{std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
  if (stream.bad()) throw InputError(file.string() + ": file cannot be read");
  if (content.empty()) throw InputError(file.string() + ":1: file is empty");
  return content;
}

CsvReader::CsvReader(const std::filesystem::path& file, std::string columns, std::size_t min_columns,
                     std::size_t max_columns)
    : file_(file),
      description_(std::move(columns)),
      min_columns_(min_columns),
      max_columns_(max_columns),
      content_(read_file(file)) {}

bool CsvReader::next_row() {
  do {
    if (!next_line()) {
      if (rows_ == 0) fail("at least one row of " + description_ + ", found the end of the file");
      return false;
    }
  } while (row_.empty() || row_.front() == '#');

  split();
  if (is_cut()) return leave_out_cut_line();
  if (fields_.size() < min_columns_ || fields_.size() > max_columns_)
    fail(description_ + ", found " + std::to_string(fields_.size()) + " columns");
  // A file keeps the number of columns of its first row: a shorter row later is a torn line, not an optional column.
  if (rows_++ == 0) min_columns_ = max_columns_ = fields_.size();
  return true;
}

bool CsvReader::next_line() {
  if (position_ >= content_.size()) return false;
  std::size_t end = content_.find('\n', position_);
  if (end == std::string::npos) end = content_.size();
  row_ = trimmed(std::string_view(content_).substr(position_, end - position_));
  position_ = end + 1;
  ++line_;
  return true;
}

/// A last line without an end: nothing tells a file that a killed
/// writer cut inside a number from one that was written so.
bool CsvReader::is_cut() const { return position_ > content_.size(); }

bool CsvReader::leave_out_cut_line() {
  if (rows_ == 0) fail("at least one whole row of " + description_ + ", found one that does not end");
  std::cerr << "segcal: " << file_.string() << ":" << line_
            << ": the last line does not end, so that it may be cut: it is left out" << std::endl;
  return false;
}

void CsvReader::split() {
  fields_.clear();
  std::string_view rest = row_;
  for (std::size_t comma; (comma = rest.find(',')) != std::string_view::npos; rest.remove_prefix(comma + 1))
    fields_.push_back(trimmed(rest.substr(0, comma)));
  fields_.push_back(trimmed(rest));
}

double CsvReader::number(std::size_t column) const {
  double value = 0;
  if (!parse(fields_[column], value)) fail_field(column, "a number");
  return value;
}

std::int64_t CsvReader::integer(std::size_t column) const {
  std::int64_t value = 0;
  if (!parse(fields_[column], value)) fail_field(column, "a whole number");
  return value;
}

std::int64_t CsvReader::stamp(std::size_t column) const {
  constexpr std::int64_t most = std::int64_t{1} << 62;
  const std::int64_t value = integer(column);
  if (value < -most || value > most) fail_field(column, "a stamp within 146 years of zero");
  return value;
}

std::uint32_t CsvReader::identifier(std::size_t column) const {
  const std::int64_t value = integer(column);
  if (value < 0 || value > std::numeric_limits<std::uint32_t>::max()) fail_field(column, "0 to 4294967295");
  return static_cast<std::uint32_t>(value);
}

void CsvReader::fail(const std::string& expected) const {
  throw InputError(file_.string() + ":" + std::to_string(line_) + ": expected " + expected);
}

void CsvReader::fail_field(std::size_t column, const char* expected) const {
  fail(std::string(expected) + " in column " + std::to_string(column + 1) + " of " + description_ + ", found \"" +
       std::string(fields_[column].substr(0, 40)) + "\"");
}

}  // namespace host
