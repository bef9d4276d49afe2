#include "twin/twin_report.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "formatted.h"

namespace host::twin {
namespace {

using Json = nlohmann::ordered_json;

std::string left_of(const Statistic& s) {
  if (!s.differs()) return "as it was";
  return formatted("%.0f +- %.0f %%", 100 * s.left(), 100 * s.left_sigma());
}

/// Less than four fifths.
bool covers_little(const Comparison& c) { return c.seconds < 0.8 * c.recorded_s; }

}  // namespace

std::string as_table(const Comparison& c) {
  if (!c.why_not.empty()) return "no twin: " + c.why_not + "\n";
  std::string out =
      formatted("\ntwin: %.0f s of the same motion and corners, simulated without effects and with\n", c.seconds);
  for (const std::string& e : c.effects) out += "  " + e + "\n";
  if (covers_little(c))
    out += formatted("  the figures that were measured are of all %.0f s: elsewhere the odometry stops or jumps\n",
                     c.recorded_s);
  out += formatted("%-50s %10s %9s %10s %10s %12s\n", "", "measured", "+- chance", "without", "with", "left");
  for (const Statistic& s : c.statistics) {
    const std::string name = s.name + (s.unit == "-" ? "" : " [" + s.unit + "]");
    out += formatted("%-50s %10.4g %9.2g %10.4g %10.4g %12s\n", name.c_str(), s.measured, s.sigma, s.plain,
                     s.with_effects, left_of(s).c_str());
  }
  for (const std::string& n : c.not_simulated) out += "not simulated: " + n + "\n";
  return out + "without, diagnosed: " + c.said_of_plain + "\nwith, diagnosed: " + c.said_of_twin + "\n";
}

std::string as_json(const Comparison& c) {
  Json statistics = Json::array();
  for (const Statistic& s : c.statistics) {
    statistics.push_back({{"name", s.name},
                          {"unit", s.unit},
                          {"measured", s.measured},
                          {"sigma", s.sigma},
                          {"without", s.plain},
                          {"with", s.with_effects},
                          {"left", s.differs() ? Json(s.left()) : Json()},
                          {"left_sigma", s.differs() ? Json(s.left_sigma()) : Json()}});
  }
  Json out;
  out["format"] = 1;
  out["why_not"] = c.why_not;
  out["seconds"] = c.seconds;
  out["recorded_s"] = c.recorded_s;
  out["effects"] = c.effects;
  out["not_simulated"] = c.not_simulated;
  out["statistics"] = statistics;
  out["without_diagnosed"] = c.said_of_plain;
  out["with_diagnosed"] = c.said_of_twin;
  return out.dump(1) + "\n";
}

}  // namespace host::twin
