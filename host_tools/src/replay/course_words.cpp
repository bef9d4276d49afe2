// How the calibration changed over sessions, in words.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "replay/words.h"

namespace host {
namespace {

constexpr std::size_t most = 3;  // entries that are listed
constexpr double sure = 4;       // sigmas: one of 27 entries reaches that by chance once in 600 courses

bool has(const CoreCourse& course, const char* form) {
  return std::find(course.courses.begin(), course.courses.end(), form) != course.courses.end();
}

/// "cam0.fx by 0.031 +- 0.002 px per degC, ...": the surest.
std::string rates_of(const CoreResult& r) {
  const CoreCourse& c = r.course;
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < c.rate.size() && i < r.parameters.size(); ++i) order.push_back(i);
  const auto sigmas = [&c](std::size_t i) { return c.sigma[i] > 0 ? std::abs(c.rate[i]) / c.sigma[i] : 0; };
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return sigmas(a) > sigmas(b); });
  std::string words;
  char line[160];
  for (std::size_t k = 0; k < order.size() && k < most && (k == 0 || sigmas(order[k]) > sure); ++k) {
    const CoreParameter& p = r.parameters[order[k]];
    std::snprintf(line, sizeof line, "%s%s by %.3g +- %.2g%s%s%s", k > 0 ? ", " : "", p.name.c_str(), c.rate[order[k]],
                  c.sigma[order[k]], p.unit == "-" ? "" : " ", p.unit == "-" ? "" : p.unit.c_str(),
                  c.rate_of == "trend"         ? " per session"
                  : c.rate_of == "temperature" ? " per degC"
                                               : "");
    words += line;
  }
  return words;
}

}  // namespace

std::string course_words(const CoreResult& r) {
  const CoreCourse& c = r.course;
  if (c.courses.empty() || c.rate_of.empty()) return "";
  const std::string step = "by a step before session " + std::to_string(c.step_session + 1);
  const auto in_words = [&](const std::string& form) -> std::string {
    if (form == "trend") return "steadily with time";
    if (form == "temperature") return "with temperature";
    return c.rate_of == "steps" ? step : "by steps";
  };
  std::string words = "over " + std::to_string(c.sessions) + " sessions the calibration changes ";
  for (std::size_t k = 0; k < c.courses.size(); ++k) words += (k > 0 ? " or " : "") + in_words(c.courses[k]);
  if (c.courses.size() > 1) words += " (they do not tell which). If it is " + in_words(c.rate_of);
  words += ": " + rates_of(r);
  if (c.courses.size() > 1 || !has(c, "steps") || c.rate_of == "steps")
    words += ". The result is a mean over the sessions, and its sigmas hold how far that is from " +
             std::string(c.rate_of == "temperature" ? "each of them" : "the last one");
  if (has(c, "temperature") && words.find(": cam") != std::string::npos)
    words += ". --enable camera_temperature estimates that of the camera";
  return words;
}

std::string open_change_words(const CoreResult& result) {
  const std::string course = course_words(result);
  return change_words(result.changes.back(), result) + (course.empty() ? "" : "; before that, " + course);
}

}  // namespace host
