#include "replay/words.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace host {

std::vector<std::pair<std::string, double>> main_weights(const CoreDirection& direction,
                                                         const std::vector<std::string>& names, double least) {
  std::vector<std::pair<std::string, double>> out;
  for (std::size_t i = 0; i < direction.weight.size() && i < names.size(); ++i) {
    if (std::abs(direction.weight[i]) >= least) out.emplace_back(names[i], direction.weight[i]);
  }
  std::stable_sort(out.begin(), out.end(),
                   [](const auto& a, const auto& b) { return std::abs(a.second) > std::abs(b.second); });
  return out;
}

std::string in_words(const CoreDirection& direction, const std::vector<std::string>& names) {
  std::string text;
  for (const auto& [name, weight] : main_weights(direction, names)) {
    char number[32] = "";
    if (std::abs(weight) < 0.95) std::snprintf(number, sizeof number, "%.1f ", std::abs(weight));
    text += text.empty() ? (weight < 0 ? "-" : "") : (weight < 0 ? " - " : " + ");
    text += number + name;
  }
  return text + ": not excited";
}

std::vector<std::string> parameter_names(const Calibration& calibration) {
  std::vector<std::string> names;
  for (std::size_t c = 0; c < calibration.cameras.size(); ++c) {
    const std::string cam = "cam" + std::to_string(c) + ".";
    for (const char* n : {"r_CI.x", "r_CI.y", "r_CI.z", "p_CI.x", "p_CI.y", "p_CI.z", "fx", "fy", "cx", "cy"})
      names.push_back(cam + n);
    for (const std::string& n : distortion_parameters(calibration.cameras[c].model)) names.push_back(cam + n);
  }
  for (const char* sensor : {"gyro.", "accel."}) {
    for (const char* n : {"sx", "sy", "sz", "mx", "my", "mz"}) names.push_back(std::string(sensor) + n);
  }
  for (const char* n : {"x", "y", "z"}) names.push_back(std::string("accel.r_AI.") + n);
  return names;
}

std::vector<std::string> parameter_names(const CoreResult& result, const Calibration& calibration) {
  if (result.parameters.empty()) return parameter_names(calibration);
  std::vector<std::string> names;
  for (const CoreParameter& p : result.parameters) names.push_back(p.name);
  return names;
}

Surest surest_of(const std::vector<double>& values, const std::vector<double>& sigmas, const CoreResult& result,
                 const std::string& per) {
  constexpr std::size_t kMost = 3;
  constexpr double kSure = 4;  // sigmas: one of 27 entries reaches that by chance once in 600 changes
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < values.size() && i < result.parameters.size(); ++i) order.push_back(i);
  const auto distance = [&](std::size_t i) { return sigmas[i] > 0 ? std::abs(values[i]) / sigmas[i] : 0; };
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return distance(a) > distance(b); });
  Surest out;
  out.sure = !order.empty() && distance(order[0]) > kSure;
  for (std::size_t k = 0; k < order.size() && k < kMost && (k == 0 || distance(order[k]) > kSure); ++k) {
    const CoreParameter& p = result.parameters[order[k]];
    char line[120];
    std::snprintf(line, sizeof line, "%s%s by %.3g +- %.2g", k > 0 ? ", " : "", p.name.c_str(), values[order[k]],
                  sigmas[order[k]]);
    out.words += line + (p.unit == "-" ? std::string() : " " + p.unit) + per;
  }
  return out;
}

std::string change_words(const CoreChange& c, const CoreResult& result) {
  char line[160];
  const std::string before = std::to_string(c.before_session + 1), after = std::to_string(c.after_session + 1);
  std::snprintf(line, sizeof line, ", %.1f s on the IMU's clock", 1e-9 * static_cast<double>(c.t_ns));
  const std::string when = c.before_session == c.after_session ? "within session " + after + line
                                                               : "between session " + before + " and " + after;
  if (c.open) {
    return "segments contradict what was known (noticed " + when +
           "): the device may have changed, and too few have come since to tell. Go on with lively motion, as for a "
           "first calibration";
  }
  const Surest most = surest_of(c.step, c.sigma, result, "");
  return "the device changed " + when +
         (most.sure ? ": " : ": no entry alone is sure, all together are; most of all ") + most.words;
}

}  // namespace host
