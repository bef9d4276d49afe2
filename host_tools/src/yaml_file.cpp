#include "yaml_file.h"

#include <Eigen/LU>
#include <Eigen/SVD>
#include <cmath>

#include "csv.h"
#include "files/manifest.h"
#include "recording.h"

namespace host {

YamlFile::YamlFile(const std::filesystem::path& file) : file_(file) {
  const std::string content = read_file(file);
  check_file(file);
  try {
    root_ = YAML::Load(content);
  } catch (const YAML::ParserException& error) {
    throw InputError(file.string() + ":" + std::to_string(error.mark.line + 1) + ": expected YAML: " + error.msg);
  }
  if (!root_.IsMap()) throw InputError(file.string() + ":1: expected a YAML map of names and values");
}

void YamlFile::fail(const YAML::Node& node, const std::string& expected) const {
  const int line = node.IsDefined() ? node.Mark().line : 0;
  throw InputError(file_.string() + ":" + std::to_string(line < 0 ? 1 : line + 1) + ": expected " + expected);
}

YAML::Node YamlFile::child(const YAML::Node& node, const std::string& key) const {
  if (!node.IsMap()) fail(node, "a map with the entry '" + key + "'");
  const YAML::Node found = node[key];
  if (!found.IsDefined() || found.IsNull()) fail(node, "an entry '" + key + "' here");
  return found;
}

std::string YamlFile::text(const YAML::Node& node, const std::string& key) const {
  const YAML::Node found = child(node, key);
  if (!found.IsScalar()) fail(found, "text for '" + key + "'");
  return found.Scalar();
}

double YamlFile::finite(const YAML::Node& node, const std::string& what) const {
  double value = 0;
  if (!node.IsScalar() || !YAML::convert<double>::decode(node, value) || !std::isfinite(value))
    fail(node, "a finite number for " + what);
  return value;
}

double YamlFile::number(const YAML::Node& node, const std::string& key) const {
  return finite(child(node, key), "'" + key + "'");
}

double YamlFile::number_or(const YAML::Node& node, const std::string& key, double fallback) const {
  return node.IsMap() && node[key].IsDefined() ? number(node, key) : fallback;
}

std::vector<double> YamlFile::numbers(const YAML::Node& node, const std::string& key, std::size_t size) const {
  const YAML::Node list = child(node, key);
  if (!list.IsSequence() || list.size() != size)
    fail(list, "a list of " + std::to_string(size) + " numbers for '" + key + "'");
  std::vector<double> values;
  for (const YAML::Node& entry : list) values.push_back(finite(entry, "'" + key + "'"));
  return values;
}

std::vector<double> YamlFile::flattened(const YAML::Node& node, const std::string& key, std::size_t size) const {
  const YAML::Node matrix = child(node, key);
  const YAML::Node rows = matrix.IsMap() ? child(matrix, "data") : matrix;
  std::vector<double> values;
  if (rows.IsSequence()) {
    for (const YAML::Node& row : rows) {
      if (row.IsSequence())
        for (const YAML::Node& entry : row) values.push_back(finite(entry, "'" + key + "'"));
      else
        values.push_back(finite(row, "'" + key + "'"));
    }
  }
  if (values.size() != size) fail(matrix, std::to_string(size) + " numbers for the matrix '" + key + "'");
  return values;
}

Eigen::Matrix3d YamlFile::matrix3(const YAML::Node& node, const std::string& key) const {
  const std::vector<double> values = flattened(node, key, 9);
  return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(values.data());
}

Eigen::Matrix4d YamlFile::transform(const YAML::Node& node, const std::string& key) const {
  const std::vector<double> values = flattened(node, key, 16);
  Eigen::Matrix4d T = Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(values.data());
  const Eigen::Matrix3d R = T.topLeftCorner<3, 3>();
  const double error = (R * R.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  if (error > 1e-3 || R.determinant() < 0) fail(child(node, key), "a rotation in the upper left 3x3 of '" + key + "'");
  if (T.row(3) != Eigen::RowVector4d(0, 0, 0, 1)) fail(child(node, key), "the last row of '" + key + "' to be 0 0 0 1");
  T.topLeftCorner<3, 3>() = nearest_rotation(R);
  return T;
}

Eigen::Matrix3d nearest_rotation(const Eigen::Matrix3d& matrix) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(matrix, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector3d signs(1, 1, (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1);
  return svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
}

}  // namespace host
