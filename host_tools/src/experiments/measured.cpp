// Right on measured data? Rendered images with the real tracker, real IMUs along real paths, and a real recording, each
// with a truth to judge by. The headline is the number of wrong answers: `calibrated` with an entry beyond five sigma.
#include "experiments/measured.h"

#include <algorithm>
#include <cmath>
#include <iostream>
#include <map>

#include "experiments/registry.h"
#include "experiments/statistics.h"
#include "recording.h"

namespace host::experiments {
namespace {

constexpr double rendered_least = 0.7, rendered_most = 1.5;  // mean (error / sigma)^2 over all entries
constexpr double real_imu_most = 2;                          // of the camera's entries
constexpr double common_sigmas = 3;

const char* const sequences[] = {"MH_03_medium", "V1_02_medium", "V2_01_easy", "tumvi_room1", "tumvi_room4"};

void add_rendered(const StudyOptions& options, std::vector<Cell>& cells) {
  const int devices = options.quick ? 2 : 30;
  for (int i = 0; i < devices; ++i) {
    const std::uint64_t seed = options.seed + static_cast<std::uint64_t>(i);
    for (const char* scenario : {"arvr", "nav", "rich"})
      cells.push_back({std::string("rendered_") + scenario + "_seed" + std::to_string(seed),
                       {{"group", std::string("rendered ") + scenario},
                        {"kind", "rendered"},
                        {"scenario", scenario},
                        {"seconds", options.quick ? 30 : 60},
                        {"rate_hz", 20},
                        {"seed", seed},
                        {"line_delay_s", 0.0}}});
    if (options.quick && i > 0) continue;
    cells.push_back({"rendered_rolling_seed" + std::to_string(seed),
                     {{"group", "rendered rich, rolling shutter"},
                      {"kind", "rendered"},
                      {"scenario", "rich"},
                      {"seconds", options.quick ? 30 : 60},
                      {"rate_hz", 20},
                      {"seed", seed},
                      {"line_delay_s", 4e-5}}});
  }
}

void add_imu_gt(const StudyOptions& options, const std::string& data, std::vector<Cell>& cells) {
  const int devices = options.quick ? 1 : 3;
  for (const char* sequence : sequences)
    for (const bool real : {true, false})
      for (int i = 0; i < devices; ++i) {
        const std::uint64_t seed = options.seed + static_cast<std::uint64_t>(i);
        cells.push_back({std::string(sequence) + (real ? "_real_seed" : "_simulated_seed") + std::to_string(seed),
                         {{"group", real ? "real IMU" : "simulated IMU, the same paths"},
                          {"kind", "imu_gt"},
                          {"sequence", sequence},
                          {"data", data},
                          {"seconds", 150},
                          {"seed", seed},
                          {"real_imu", real}}});
      }
}

void add_euroc(const StudyOptions& options, const std::string& data, std::vector<Cell>& cells) {
  const int starts = options.quick ? 3 : 11;
  for (const int factor : {1, 3, 5})
    for (int start = 0; start < (factor == 1 ? starts : starts / 2); ++start)
      cells.push_back(
          {"euroc_x" + std::to_string(factor) + "_start" + std::to_string(start),
           {{"group", factor == 1 ? "euroc_mh01" : "euroc_mh01, start " + std::to_string(factor) + " times as far off"},
            {"kind", "euroc"},
            {"data", data},
            {"start", start},
            {"factor", factor}}});
}

struct Tally {
  std::map<std::string, std::vector<double>> z;  ///< by entry, of calibrated answers
  std::vector<double> all, camera, fit;
  int n = 0, calibrated = 0, wrong = 0;
};

double mean_square(const std::vector<double>& z) {
  double sum = 0;
  for (const double v : z) sum += v * v;
  return z.empty() ? std::nan("") : sum / static_cast<double>(z.size());
}

double share_within(const std::vector<double>& z, double sigmas) {
  const auto n = std::count_if(z.begin(), z.end(), [sigmas](double v) { return std::abs(v) <= sigmas; });
  return z.empty() ? std::nan("") : static_cast<double>(n) / static_cast<double>(z.size());
}

void add(const Json& result, Tally& group) {
  ++group.n;
  if (result.at("status") != "calibrated") return;
  ++group.calibrated;
  group.wrong += result.at("wrong").get<bool>() ? 1 : 0;
  group.fit.push_back(result.at("chi2_per_dof"));
  for (const Json& e : result.at("entries")) {
    const std::string name = e.at("name");
    group.z[name].push_back(e.at("z"));
    group.all.push_back(e.at("z"));
    if (name.rfind("cam", 0) == 0) group.camera.push_back(e.at("z"));
  }
}

Table runs_table(const std::vector<CellResult>& cells) {
  Table table{"Every run",
              "",
              {{"group", ""},
               {"run", ""},
               {"status", ""},
               {"frames used", "-"},
               {"of", "-"},
               {"segments", "-"},
               {"chi2/dof", "-"},
               {"mean (error/sigma)^2", "-"},
               {"largest", "sigma"},
               {"entry", ""},
               {"wrong", "-"}},
              {}};
  for (const CellResult& c : cells) {
    const Json &r = c.result, &p = c.parameters;
    std::vector<double> z;
    for (const Json& e : r.at("entries")) z.push_back(e.at("z"));
    const std::string run = (p.contains("sequence") ? p.at("sequence").get<std::string>() + " " : "") +
                            (p.contains("seed") ? "seed " + p.at("seed").dump() : "start " + p.at("start").dump());
    table.rows.push_back({p.at("group"), run, r.at("status"), r.at("frames_used"), r.at("frames"), r.at("segments"),
                          r.at("chi2_per_dof"), z.empty() ? Json() : Json(mean_square(z)), r.at("largest"),
                          r.at("largest_of"), r.at("wrong").get<bool>() ? 1 : 0});
  }
  return table;
}

}  // namespace

std::vector<Cell> measured_cells(const StudyOptions& options) {
  std::vector<Cell> cells;
  add_rendered(options, cells);
  const auto data = find_real_data();
  if (!data) {
    std::cerr << "measured: no real data (SEGCAL_DATA or ../shared/data): rendered recordings only\n";
    return cells;
  }
  if (std::filesystem::exists(*data / "imu_gt")) add_imu_gt(options, data->string(), cells);
  if (std::filesystem::exists(*data / "euroc_mh01")) add_euroc(options, data->string(), cells);
  return cells;
}

Json measured_run(const Json& parameters) {
  const std::string kind = parameters.at("kind");
  if (kind == "rendered") return calibrate_rendered(parameters);
  return kind == "imu_gt" ? calibrate_imu_gt(parameters) : calibrate_euroc(parameters);
}

Findings measured_gather(const std::vector<CellResult>& cells) {
  std::map<std::string, Tally> groups;
  Tally rendered, real_imu;
  int wrong = 0, released = 0;
  for (const CellResult& c : cells) {
    const std::string name = c.parameters.at("group");
    add(c.result, groups[name]);
    if (name.rfind("rendered", 0) == 0) add(c.result, rendered);
    if (name == "real IMU") add(c.result, real_imu);
    wrong += c.result.at("wrong").get<bool>() ? 1 : 0;
    released += c.result.at("status") == "calibrated" ? 1 : 0;
  }
  Table table{"By group",
              "Over calibrated answers. Wrong: calibrated with a released entry beyond 5 sigma.",
              {{"group", ""},
               {"runs", "-"},
               {"calibrated", "-"},
               {"wrong", "-"},
               {"mean (error/sigma)^2", "-"},
               {"of the camera's entries", "-"},
               {"share within 3 sigma", "-"},
               {"median chi2/dof", "-"}},
              {}};
  Table entries{
      "By entry",
      "",
      {{"group", ""}, {"entry", ""}, {"answers", "-"}, {"mean (error/sigma)^2", "-"}, {"share within 3 sigma", "-"}},
      {}};
  for (const auto& [name, g] : groups) {
    const bool any = !g.all.empty();
    table.rows.push_back({name, g.n, g.calibrated, g.wrong, any ? Json(mean_square(g.all)) : Json(),
                          g.camera.empty() ? Json() : Json(mean_square(g.camera)),
                          any ? Json(share_within(g.all, common_sigmas)) : Json(), any ? Json(median(g.fit)) : Json()});
    for (const auto& [entry, z] : g.z)
      entries.rows.push_back({name, entry, z.size(), mean_square(z), share_within(z, common_sigmas)});
  }
  Findings out;
  out.tables = {table, entries, runs_table(cells)};
  out.limits.push_back({"wrong answers of " + std::to_string(released) + " called calibrated",
                        static_cast<double>(wrong), 0, "-", false});
  if (!rendered.all.empty()) {
    out.limits.push_back(
        {"mean (error/sigma)^2, rendered images", mean_square(rendered.all), rendered_most, "-", false});
    out.limits.push_back({"the same, least", mean_square(rendered.all), rendered_least, "-", true});
  }
  if (!real_imu.camera.empty())
    out.limits.push_back({"mean (error/sigma)^2 of the camera's entries, real IMU", mean_square(real_imu.camera),
                          real_imu_most, "-", false});
  return out;
}

}  // namespace host::experiments
