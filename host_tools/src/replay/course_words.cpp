// How the calibration changed over sessions, in words.
#include "replay/words.h"

namespace host {

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
  const char* const per = c.rate_of == "trend" ? " per session" : c.rate_of == "temperature" ? " per degC" : "";
  const std::string rates = surest_of(c.rate, c.sigma, r, per).words;
  words += ": " + rates + ". The result is a mean over the sessions, and its sigmas hold how far that is from " +
           (c.rate_of == "temperature" ? "each of them" : "the last one");
  if (c.rate_of == "temperature" && rates.compare(0, 3, "cam") == 0)
    words += ". --enable camera_temperature estimates that of the camera";
  return words;
}

std::string open_change_words(const CoreResult& result) {
  const std::string course = course_words(result);
  return change_words(result.changes.back(), result) + (course.empty() ? "" : "; before that, " + course);
}

}  // namespace host
