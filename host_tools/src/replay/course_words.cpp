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
    std::snprintf(line, sizeof line, "%s%s by %.3g +- %.2g%s%s %s", k > 0 ? ", " : "", p.name.c_str(), c.rate[order[k]],
                  c.sigma[order[k]], p.unit == "-" ? "" : " ", p.unit == "-" ? "" : p.unit.c_str(),
                  c.rate_of == "trend" ? "per session" : "per degC");
    words += line;
  }
  return words;
}

}  // namespace

std::string course_words(const CoreResult& r) {
  const CoreCourse& c = r.course;
  const bool steps = has(c, "steps"), trend = has(c, "trend"), warm = has(c, "temperature");
  if (!trend && !warm) return "";
  const std::string over = "over " + std::to_string(c.sessions) + " sessions ";
  std::string words;
  if (trend && warm) {
    words = over + "the calibration changes with time or with temperature" + (steps ? ", or by steps" : "") +
            ": these sessions do not tell them apart. If it is " +
            (c.rate_of == "trend" ? "a trend: " : "temperature: ");
  } else if (steps) {
    words = over + "the calibration changes by steps or " + (trend ? "steadily with time" : "with temperature") +
            ": these sessions do not tell them apart. If it is the latter: ";
  } else {
    words = over + (trend ? "the calibration changes steadily with time, not by steps: "
                          : "the calibration follows the temperature: ");
  }
  words += rates_of(r);
  if (!steps)
    words += ". The result is their mean; its sigmas hold how far that is from " +
             std::string(trend ? "the last session" : "each") + "'s";
  if (warm && !steps && !trend) words += ". --enable camera_temperature estimates that of the camera";
  return words;
}

}  // namespace host
