// The values of an effect, from the text that a command line
// gives. Functions throw InputError that says what was expected.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace host::sim::effect_values {

using Values = std::vector<std::string>;

/// "v1,v2,..." at its commas.
Values split(const std::string& text);

/// As many values as that, both included.
void expect(const Values& values, std::size_t least, std::size_t most);

/// Below 1e12 in size.
double number(const std::string& text);
double positive(const std::string& text);  ///< above 0
std::vector<double> numbers(const Values& values, std::size_t from = 0);
Eigen::Vector3d three(const Values& values);  ///< exactly

}  // namespace host::sim::effect_values
