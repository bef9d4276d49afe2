// What the study of faults showed (faults.cpp): what was reported by name, and what was called calibrated and is wrong.
#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "experiments/registry.h"
#include "simulate/fault_kinds.h"

namespace host::experiments {
namespace {

using sim::FaultKind, sim::fault_kind, sim::fault_kinds;

/// What a run named: counters that stand above those of the clean recording, suspects, the clock's offset, the cause.
std::set<std::string> named(const Json& result, const Json& clean) {
  std::set<std::string> out;
  for (const auto& [name, count] : result.at("said").at("counters").items())
    if (count.get<double>() > (clean.contains(name) ? clean.at(name).get<double>() : 0)) out.insert(name);
  for (const Json& s : result.at("said").at("suspects")) out.insert(s.get<std::string>());
  if (result.at("said").at("clock").is_string()) out.insert("time_offset");
  return out;
}

bool reported(const FaultKind& kind, const std::set<std::string>& names, const std::string& cause) {
  if (kind.names.empty()) return true;
  for (const std::string& part : kind.names) {
    if (cause.find(part) != std::string::npos) return true;
    for (const std::string& name : names)
      if (name.find(part) != std::string::npos) return true;
  }
  return false;
}

struct KindRow {
  int n = 0, calibrated = 0, wrong = 0, reported = 0;
  double largest_sigmas = 0;
  std::string largest_of;
  std::map<std::string, int> names;
  std::string cause;
  double seconds = 0;
};

std::string joined(const std::map<std::string, int>& names, int n) {
  std::string out;
  for (const auto& [name, count] : names)
    out += (out.empty() ? "" : ", ") + name + (count < n ? " (" + std::to_string(count) + ")" : "");
  return out;
}

/// Adds a run to its kind's row, and to `wrong` if it is. `clean`: counters of the recording without a fault.
void add_run(const CellResult& c, const Json& clean, KindRow* row, Table* wrong) {
  const FaultKind& kind = fault_kind(c.parameters.at("kind"));
  const std::set<std::string> names = named(c.result, clean);
  const std::string cause = c.result.at("said").at("cause");
  const double sigmas = c.result.at("largest").is_null() ? INFINITY : c.result.at("largest").get<double>();
  ++row->n;
  row->reported += reported(kind, names, cause) ? 1 : 0;
  for (const std::string& name : names) ++row->names[name];
  row->seconds = std::max(row->seconds, c.result.at("seconds").get<double>());
  if (c.result.at("status") != "calibrated") {
    if (row->cause.empty()) row->cause = cause;
    return;
  }
  ++row->calibrated;
  if (sigmas > row->largest_sigmas) {
    row->largest_sigmas = sigmas;
    row->largest_of = c.result.at("largest_of").get<std::string>();
  }
  if (sigmas <= wrong_sigmas) return;
  ++row->wrong;
  std::map<std::string, int> once;
  for (const std::string& name : names) once[name] = 1;
  wrong->rows.push_back({kind.name, c.parameters.at("seed"), sigmas, c.result.at("largest_of"),
                         c.result.at("chi2_per_dof"), joined(once, 1)});
}

}  // namespace

Findings faults_gather(const std::vector<CellResult>& cells) {
  std::map<std::string, Json> clean;  // counters, by seed
  for (const CellResult& c : cells)
    if (c.parameters.at("kind") == fault_kinds().front().name)
      clean[c.parameters.at("seed").dump()] = c.result.at("said").at("counters");
  std::map<std::string, KindRow> rows;
  Table wrong{"Called calibrated, and wrong",
              "Beyond five sigma.",
              {{"fault", ""}, {"seed", "-"}, {"largest error", "sigma"}, {"of", ""}, {"chi2/dof", "-"}, {"named", ""}},
              {}};
  for (const CellResult& c : cells)
    add_run(c, clean[c.parameters.at("seed").dump()], &rows[c.parameters.at("kind")], &wrong);
  Table table{"Faults",
              "Named: fault counters above those of the clean recording, suspects of the review, the clock's offset; "
              "in brackets the runs, where it was not all. "
              "Errors are of released entries of calibrated runs, in their sigmas.",
              {{"fault", ""},
               {"what", ""},
               {"runs", "-"},
               {"reported by name", "-"},
               {"calibrated", "-"},
               {"beyond 5 sigma", "-"},
               {"largest error", "sigma"},
               {"of", ""},
               {"named", ""},
               {"cause of a refusal", ""},
               {"longest replay", "s"}},
              {}};
  int all_wrong = 0, all_calibrated = 0, unreported = 0;
  for (const FaultKind& kind : fault_kinds()) {
    if (!rows.count(kind.name)) continue;
    const KindRow& r = rows[kind.name];
    table.rows.push_back({kind.name, kind.what, r.n, r.reported, r.calibrated, r.wrong,
                          r.calibrated ? Json(r.largest_sigmas) : Json(), r.largest_of, joined(r.names, r.n), r.cause,
                          r.seconds});
    all_wrong += r.wrong;
    all_calibrated += r.calibrated;
    unreported += r.n - r.reported;
  }
  Findings out;
  out.tables = {table, wrong};
  out.limits = {{"wrong answers of " + std::to_string(all_calibrated) + " called calibrated",
                 static_cast<double>(all_wrong), 0, "-", false},
                {"runs whose fault was not reported by name", static_cast<double>(unreported), 0, "-", false}};
  return out;
}

}  // namespace host::experiments
