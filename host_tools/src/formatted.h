// A sentence with numbers in it.
#pragma once

#include <cstdio>
#include <string>

namespace host {

/// printf's format, with arguments that it knows; 500 characters at most.
template <typename... T>
std::string formatted(const char* format, T... values) {
  char buffer[500];
  std::snprintf(buffer, sizeof buffer, format, values...);
  return buffer;
}

}  // namespace host
