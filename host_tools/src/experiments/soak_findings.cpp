// What hours of stream showed (soak.cpp), as a table and limits.
#include <algorithm>
#include <cmath>

#include "experiments/registry.h"

namespace host::experiments {
namespace {

double ratio(const Json& of) {
  const double n = of.at("entries");
  return n > 0 ? of.at("sum_of_squares").get<double>() / n : std::nan("");
}

std::string calibrated_of(const Json& of) {
  return std::to_string(of.at("calibrated").get<int>()) + " of " + std::to_string(of.at("sessions").get<int>());
}

}  // namespace

Findings soak_gather(const std::vector<CellResult>& cells) {
  Table table{
      "A day of stream",
      "Times are CPU times of this machine. Errors: mean (error / sigma)^2 of the released entries of a session's "
      "calibration, sessions without and with faults. Tilt and speed: medians of the odometry's error, sessions "
      "without faults. Condition: of the last triangle of a calibration, in units of the prior.",
      {{"profile", ""},
       {"seed", "-"},
       {"from", "h"},
       {"frame", "ms"},
       {"frame, 99.9 %", "ms"},
       {"segment", "ms"},
       {"calibration", "ms"},
       {"calibrated, clean", ""},
       {"errors, clean", "-"},
       {"calibrated, faults", ""},
       {"errors, faults", "-"},
       {"beyond 5 sigma", ""},
       {"log10 condition", "-"},
       {"tilt", "mrad"},
       {"speed", "mm/s"}},
      {}};
  double squares = 0, entries = 0, slowest = 0, grown_kb = 0;
  int wrong_clean = 0;
  for (const CellResult& c : cells) {
    const double hours = c.parameters.at("hours");
    const Json& first = c.result.at("parts").front();
    grown_kb = std::max(grown_kb, c.result.at("peak_kb").get<double>() - c.result.at("peak_kb_first").get<double>());
    for (const Json& p : c.result.at("parts")) {
      if (p.at("frames").get<int>() == 0) continue;  // fewer sessions than parts
      const Json &clean = p.at("clean"), &faults = p.at("with_faults");
      table.rows.push_back(
          {c.parameters.at("profile"), c.parameters.at("seed"),
           hours * p.at("part").get<int>() / static_cast<double>(c.result.at("parts").size()), p.at("frame_ms"),
           p.at("frame_ms_most"), p.at("score_ms"), p.at("calibrate_ms"), calibrated_of(clean), ratio(clean),
           calibrated_of(faults), ratio(faults),
           std::to_string(clean.at("wrong").get<int>()) + " + " + std::to_string(faults.at("wrong").get<int>()),
           p.at("log10_condition"), p.at("tilt_mrad"), p.at("speed_mm_s")});
      squares += clean.at("sum_of_squares").get<double>();
      entries += clean.at("entries").get<double>();
      wrong_clean += clean.at("wrong").get<int>();
      slowest = std::max(slowest, p.at("frame_ms").get<double>() / first.at("frame_ms").get<double>());
    }
  }
  Findings out;
  out.tables = {table};
  out.limits = {
      {"mean (error / sigma)^2, sessions without faults", squares / entries, 1.2, "-", false},
      {"the same, not too small", squares / entries, 0.8, "-", true},
      {"sessions without faults with an entry beyond 5 sigma", static_cast<double>(wrong_clean), 0, "-", false},
      {"slowest part's median frame over the first's", slowest, 1.1, "-", false},
      {"memory that the process gained after the second session", grown_kb / 1024, 16, "MB", false}};
  return out;
}

}  // namespace host::experiments
