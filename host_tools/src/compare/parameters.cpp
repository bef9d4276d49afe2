#include "compare/parameters.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "angles.h"
#include "calibration_file.h"
#include "csv.h"
#include "simulate/device.h"

namespace host {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

Json parsed(const fs::path& file) {
  const std::string text = read_file(file);
  try {
    Json json = Json::parse(text);
    // result.json is of format 1 or 2, truth.json of format 1: what is read here is the same in both.
    const bool known = json.is_object() && (!json.contains("format") || json["format"] == 1 || json["format"] == 2);
    if (!known) throw InputError(file.string() + ":1: expected an object of format 1 or 2");
    return json;
  } catch (const Json::out_of_range& error) {
    throw InputError(file.string() + ": expected JSON with numbers that fit a double: " + error.what());
  } catch (const Json::parse_error& error) {
    const auto end = text.begin() + static_cast<std::ptrdiff_t>(std::min(error.byte, text.size()));
    throw InputError(file.string() + ":" + std::to_string(1 + std::count(text.begin(), end, '\n')) + ": expected JSON");
  }
}

/// The list "parameters" of a file; empty if it has none.
ParameterList listed(const fs::path& file) {
  const Json json = parsed(file);
  ParameterList out;
  try {
    for (const Json& p : json.value("parameters", Json::array())) {
      ParameterEstimate one;
      one.name = p.at("name");
      one.unit = p.value("unit", "");
      one.value = p.at("value");
      one.verdict = p.value("verdict", "");
      if (p.contains("sigma") && p.at("sigma").get<double>() > 0) one.sigma = p.at("sigma").get<double>();
      out.push_back(one);
    }
  } catch (const Json::exception&) {
    throw InputError(file.string() + ": expected parameters with a name, a value and, if known, a sigma each");
  }
  return out;
}

std::optional<double> ratio(double value, const std::optional<double>& sigma) {
  if (!sigma) return std::nullopt;
  return value / *sigma;
}

std::optional<double> joint_sigma(const std::optional<double>& a, const std::optional<double>& b) {
  if (!a && !b) return std::nullopt;
  return std::hypot(a.value_or(0), b.value_or(0));
}

const ParameterEstimate* find(const ParameterList& list, const std::string& name) {
  const auto it =
      std::find_if(list.begin(), list.end(), [&name](const ParameterEstimate& p) { return p.name == name; });
  return it == list.end() ? nullptr : &*it;
}

/// Rotation vectors v and v (1 - 2 pi / |v|) are the same rotation: takes for `a` the one that is nearer to `b`.
void bring_rotations_together(ParameterList& a, const ParameterList& b) {
  for (std::size_t i = 0; i + 2 < a.size(); ++i) {
    const std::string& name = a[i].name;
    if (name.size() < 2 || name.find(".r_") == std::string::npos || name.substr(name.size() - 2) != ".x") continue;
    const std::string stem = name.substr(0, name.size() - 1);
    const ParameterEstimate *x = find(b, stem + "x"), *y = find(b, stem + "y"), *z = find(b, stem + "z");
    if (!x || !y || !z || a[i + 1].name != stem + "y" || a[i + 2].name != stem + "z") continue;
    const Eigen::Vector3d v(a[i].value, a[i + 1].value, a[i + 2].value), w(x->value, y->value, z->value);
    if (v.norm() < 0.25 * two_pi) continue;
    const Eigen::Vector3d other = v * (1 - two_pi / v.norm());
    if ((other - w).norm() >= (v - w).norm()) continue;
    for (int k = 0; k < 3; ++k) a[i + static_cast<std::size_t>(k)].value = other(k);
  }
}

}  // namespace

ParameterList read_parameters(const fs::path& dir) {
  if (!fs::is_directory(dir)) throw InputError(dir.string() + ": expected a folder that segcal wrote");
  const fs::path result = dir / "result.json", camchain = dir / "camchain-imucam.yaml";
  if (fs::exists(result)) {
    ParameterList list = listed(result);
    if (!list.empty()) return list;
  }
  if (!fs::exists(camchain))
    throw InputError(dir.string() + ": expected result.json with parameters, or camchain-imucam.yaml");
  ParameterList out;
  for (const sim::NamedParameter& p : sim::named_parameters(read_calibration(camchain), fs::exists(dir / "imu.yaml"))) {
    out.push_back({p.name, "", p.value, std::nullopt, ""});
  }
  return out;
}

ParameterList read_truth_parameters(const fs::path& file) {
  ParameterList list = listed(file);
  if (list.empty())
    throw InputError(file.string() + ": expected parameters, as `segcal simulate` writes truth/truth.json");
  for (ParameterEstimate& p : list) p.sigma.reset();
  return list;
}

SigmaOf sigma_of_from_name(const std::string& name) {
  if (name == "difference") return SigmaOf::difference;
  if (name == "a") return SigmaOf::a;
  if (name == "b") return SigmaOf::b;
  throw InputError("--sigma-of: expected difference, a or b, found '" + name + "'");
}

std::optional<double> ParameterDifference::judged(SigmaOf which) const {
  return which == SigmaOf::a ? in_a : which == SigmaOf::b ? in_b : in_difference;
}

std::vector<ParameterDifference> differences(const ParameterList& first, const ParameterList& b) {
  ParameterList a = first;
  bring_rotations_together(a, b);
  std::vector<ParameterDifference> out;
  for (const ParameterEstimate& p : a) {
    const ParameterEstimate* const q = find(b, p.name);
    if (!q) continue;
    ParameterDifference d;
    d.name = p.name;
    d.unit = p.unit.empty() ? q->unit : p.unit;
    d.a = p.value;
    d.b = q->value;
    d.difference = p.value - q->value;
    d.sigma_a = p.sigma;
    d.sigma_b = q->sigma;
    d.in_a = ratio(d.difference, p.sigma);
    d.in_b = ratio(d.difference, q->sigma);
    d.in_difference = ratio(d.difference, joint_sigma(p.sigma, q->sigma));
    out.push_back(d);
  }
  return out;
}

}  // namespace host
