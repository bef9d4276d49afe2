#include "effect_values.h"

#include <cmath>
#include <cstdlib>

#include "../recording.h"

namespace host::sim::effect_values {

Values split(const std::string& text) {
  Values parts;
  std::size_t begin = 0;
  for (std::size_t comma; (comma = text.find(',', begin)) != std::string::npos; begin = comma + 1)
    parts.push_back(text.substr(begin, comma - begin));
  parts.push_back(text.substr(begin));
  return parts;
}

void expect(const Values& values, std::size_t least, std::size_t most) {
  if (values.size() >= least && values.size() <= most) return;
  const std::string range =
      least == most ? std::to_string(least) : std::to_string(least) + " to " + std::to_string(most);
  throw InputError("expected " + range + (most == 1 ? " value, found " : " values, found ") +
                   std::to_string(values.size()));
}

double number(const std::string& text) {
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  if (text.empty() || *end != '\0' || !(std::abs(value) < 1e12))
    throw InputError("expected a number, found '" + text + "'");
  return value;
}

double positive(const std::string& text) {
  const double value = number(text);
  if (!(value > 0)) throw InputError("expected a number above 0, found '" + text + "'");
  return value;
}

std::vector<double> numbers(const Values& values, std::size_t from) {
  std::vector<double> out;
  for (std::size_t i = from; i < values.size(); ++i) out.push_back(number(values[i]));
  return out;
}

Eigen::Vector3d three(const Values& values) {
  expect(values, 3, 3);
  return {number(values[0]), number(values[1]), number(values[2])};
}

}  // namespace host::sim::effect_values
