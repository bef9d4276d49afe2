// Parametrised cases with an id that runs just one of them again.
//
// A failing case prints, for example,
//   case: model=fov type=float seed=7 column=12
// and `SEGCAL_CASE="model=fov type=float seed=7 column=12" ./test_camera` (or the same text as arguments) runs that
// case alone. Fewer words select more cases: "type=float" runs all of float.
#pragma once

#include <unity.h>
// Unity defines these as macros where <math.h> did not; C++ headers declare functions of these names.
#undef isinf
#undef isnan

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <sstream>
#include <string>
#include <type_traits>

namespace test {

/// The words "key=value" that cases are selected by.
inline std::string& selection() {
  static std::string words = std::getenv("SEGCAL_CASE") ? std::getenv("SEGCAL_CASE") : "";
  return words;
}

/// Arguments of the program are words of the selection too.
inline void select_cases(int argc, char** argv) {
  for (int i = 1; i < argc; ++i) selection() += std::string(" ") + argv[i];
}

/// The value of `key` in "a=1 b=2", or nothing.
inline std::string value_of(const std::string& words, const std::string& key) {
  std::istringstream in(words);
  for (std::string word; in >> word;) {
    const std::size_t equals = word.find('=');
    if (equals != std::string::npos && word.substr(0, equals) == key) return word.substr(equals + 1);
  }
  return "";
}

/// False if the selection names one of the case's keys with another value.
inline bool selected(const std::string& id) {
  std::istringstream in(id);
  for (std::string word; in >> word;) {
    const std::size_t equals = word.find('=');
    const std::string wanted = value_of(selection(), word.substr(0, equals));
    if (!wanted.empty() && wanted != word.substr(equals + 1)) return false;
  }
  return true;
}

/// Limits that are not met today (README, "Known limits") are asked for too: such tests are red.
inline bool open_limits() { return std::getenv("SEGCAL_OPEN_LIMITS") != nullptr; }

/// The goal where it is asked for, else `today`: what was measured, with some room.
inline double open_limit(double goal, double today) { return open_limits() ? goal : today; }

template <class S>
const char* type_name() {
  return std::is_same<S, float>::value ? "float" : "double";
}

/// Builds an id word by word: Id().add("model", "fov").add("seed", 7).
class Id {
 public:
  template <class T>
  Id add(const char* key, const T& value) const {
    std::ostringstream out;
    out << text_ << (text_.empty() ? "" : " ") << key << '=' << value;
    Id next;
    next.text_ = out.str();
    return next;
  }
  template <class S>
  Id type() const {
    return add("type", type_name<S>());
  }
  const std::string& text() const { return text_; }

 private:
  std::string text_;
};

/// Fails the running test with the id of the case and what was measured.
inline void fail_case(const Id& id, const std::string& what) {
  std::printf("case: %s\n", id.text().c_str());
  TEST_FAIL_MESSAGE((what + "   case: " + id.text()).c_str());
}

/// |actual - expected| <= tolerance, said with numbers. Not-a-number fails.
inline void check_near(const Id& id, const char* what, double expected, double actual, double tolerance) {
  if (!selected(id.text()) || std::fabs(actual - expected) <= tolerance) return;
  char text[256];
  std::snprintf(text, sizeof text, "%s: expected %.9g, was %.9g, off by %.3g, allowed %.3g", what, expected, actual,
                std::fabs(actual - expected), tolerance);
  fail_case(id, text);
}

/// low <= value <= high.
inline void check_between(const Id& id, const char* what, double low, double value, double high) {
  if (!selected(id.text()) || (value >= low && value <= high)) return;
  char text[256];
  std::snprintf(text, sizeof text, "%s: %.9g is not in [%.9g, %.9g]", what, value, low, high);
  fail_case(id, text);
}

inline void check_true(const Id& id, const char* what, bool condition) {
  if (selected(id.text()) && !condition) fail_case(id, what);
}

}  // namespace test
