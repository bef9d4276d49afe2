// YAML with errors that a user can act on: file, line, and what was expected there.
#pragma once

#include <yaml-cpp/yaml.h>

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

#include "recording.h"

namespace host {

/// One parsed YAML file, which its folder's manifest, if there is one, must know as whole (files/manifest.h): all that
/// segcal reads from a folder by a file's name, calibrations, models, noise, is YAML. All members throw InputError
/// "FILE:LINE: expected ..." on a fault.
class YamlFile {
 public:
  explicit YamlFile(const std::filesystem::path& file);

  const YAML::Node& root() const { return root_; }
  const std::filesystem::path& path() const { return file_; }

  /// The child of that name, which must exist.
  YAML::Node child(const YAML::Node& node, const std::string& key) const;
  std::string text(const YAML::Node& node, const std::string& key) const;
  /// A finite number.
  double number(const YAML::Node& node, const std::string& key) const;
  double number_or(const YAML::Node& node, const std::string& key, double fallback) const;
  /// A list of exactly `size` finite numbers.
  std::vector<double> numbers(const YAML::Node& node, const std::string& key, std::size_t size) const;

  /// Kalibr's list of rows, EuRoC's {rows, cols, data}, or a flat list; row-major.
  Eigen::Matrix3d matrix3(const YAML::Node& node, const std::string& key) const;
  /// As above, and the result must be a rigid transform: rotation part orthonormal to 1e-3, last row 0 0 0 1.
  /// The rotation is projected onto SO(3), which removes the rounding of printed digits.
  Eigen::Matrix4d transform(const YAML::Node& node, const std::string& key) const;

  [[noreturn]] void fail(const YAML::Node& node, const std::string& expected) const;

 private:
  double finite(const YAML::Node& node, const std::string& what) const;
  std::vector<double> flattened(const YAML::Node& node, const std::string& key, std::size_t size) const;

  std::filesystem::path file_;
  YAML::Node root_;
};

/// Calls `reader` with the parsed file. What yaml-cpp throws on a node of another kind than the reader takes it for is
/// told as an InputError with file and line.
template <class Reader>
auto read_yaml(const std::filesystem::path& file, const Reader& reader) {
  const YamlFile yaml(file);
  try {
    return reader(yaml);
  } catch (const YAML::Exception& error) {
    throw InputError(file.string() + ":" + std::to_string(error.mark.line < 0 ? 1 : error.mark.line + 1) +
                     ": expected another kind of entry here: " + error.msg);
  }
}

/// The rotation nearest to `matrix` in the Frobenius norm.
Eigen::Matrix3d nearest_rotation(const Eigen::Matrix3d& matrix);

}  // namespace host
