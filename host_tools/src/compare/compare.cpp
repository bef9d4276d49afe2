#include "compare/compare.h"

#include <algorithm>
#include <cmath>

#include "angles.h"
#include "formatted.h"
#include "recording.h"

namespace host {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

/// What is beyond the tolerances, in words. `own`: against a truth, which has no sigma, A's or B's own counts.
void judge(const ParameterComparison& c, const CompareOptions& o, Comparison* out) {
  const bool against_truth = c.against == "truth";
  int judged = 0;
  for (const ParameterDifference& d : c.parameters) {
    const std::string where = c.of + " against " + c.against + ": " + d.name;
    const auto units = d.judged(against_truth ? SigmaOf::a : o.sigma_of);
    judged += units ? 1 : 0;
    if (units && !(std::abs(*units) <= o.sigmas))
      out->exceeded.push_back(where + formatted(" %.3g sigma, tolerance %.3g", *units, o.sigmas));
    if (against_truth || !o.sigma_ratio || !d.sigma_a || !d.sigma_b) continue;
    const double ratio = *d.sigma_a / *d.sigma_b - 1;
    if (!(std::abs(ratio) <= *o.sigma_ratio))
      out->exceeded.push_back(where + formatted(" sigma differs by %.3g, tolerance %.3g", ratio, *o.sigma_ratio));
  }
  if (judged == 0)
    throw InputError(c.of + " against " + c.against + ": expected at least one parameter with a sigma in both");
}

void judge(const TrajectoryComparison& c, const CompareOptions& o, Comparison* out) {
  const std::string where = c.of + " against " + c.against + ": ";
  const double position = c.error.position_m.rmse, attitude = c.error.attitude_rad.rmse;
  if (o.position_m && !(position <= *o.position_m))
    out->exceeded.push_back(where + formatted("position RMSE %.3g m, tolerance %.3g m", position, *o.position_m));
  if (o.attitude_rad && !(attitude <= *o.attitude_rad)) {
    out->exceeded.push_back(where + formatted("attitude RMSE %.3g deg, tolerance %.3g deg", attitude / rad_per_deg,
                                              *o.attitude_rad / rad_per_deg));
  }
}

std::optional<Poses> trajectory_of(const fs::path& dir) {
  const fs::path file = dir / "trajectory.tum";
  if (!fs::exists(file)) return std::nullopt;
  return read_poses(file);
}

void add_trajectory(const std::string& of, const std::string& against, const Poses& estimate, const Poses& reference,
                    const CompareOptions& options, Comparison* out) {
  const auto error = trajectory_error(estimate, reference, options.trajectory);
  if (!error)
    throw InputError(of + " against " + against +
                     ": expected trajectories that overlap in time, found fewer than three common poses");
  out->trajectories.push_back({of, against, *error});
}

std::string verdict_of(const Comparison& c) {
  double largest = 0;
  std::size_t parameters = 0;
  for (const ParameterComparison& p : c.parameters) {
    parameters += p.parameters.size();
    for (const ParameterDifference& d : p.parameters)
      largest = std::max(largest, std::abs(d.in_difference.value_or(0)));
  }
  if (c.exceeded.empty()) {
    return "within tolerance: " + std::to_string(parameters) + " parameter differences, the largest " +
           formatted("%.3g sigma", largest) + "; " + std::to_string(c.trajectories.size()) + " trajectories";
  }
  return "above tolerance: " + std::to_string(c.exceeded.size()) + " figures, the first: " + c.exceeded.front();
}

Json optional_json(const std::optional<double>& value) { return value ? Json(*value) : Json(nullptr); }

Json json_of(const ParameterComparison& c) {
  Json list = Json::array();
  for (const ParameterDifference& d : c.parameters) {
    list.push_back({{"name", d.name},
                    {"unit", d.unit},
                    {"value", d.a},
                    {"against", d.b},
                    {"difference", d.difference},
                    {"sigma", optional_json(d.sigma_a)},
                    {"sigma_against", optional_json(d.sigma_b)},
                    {"in_sigma", optional_json(d.in_a)},
                    {"in_sigma_against", optional_json(d.in_b)},
                    {"in_sigma_of_difference", optional_json(d.in_difference)}});
  }
  return {{"of", c.of}, {"against", c.against}, {"parameters", list}};
}

Json json_of(const Spread& s, double unit, const char* name) {
  return {{std::string("rmse_") + name, s.rmse / unit},
          {std::string("median_") + name, s.median / unit},
          {std::string("max_") + name, s.max / unit},
          {"n", s.n}};
}

Json json_of(const TrajectoryComparison& c) {
  Json relative = Json::array();
  for (const RelativeError& r : c.error.relative) {
    relative.push_back({{"segment_m", r.segment_m},
                        {"position", json_of(r.position_m, 1, "m")},
                        {"attitude", json_of(r.attitude_rad, rad_per_deg, "deg")}});
  }
  return {{"of", c.of},
          {"against", c.against},
          {"poses", c.error.poses},
          {"duration_s", c.error.duration_s},
          {"path_m", c.error.path_m},
          {"time_shift_s", c.error.time_shift_s},
          {"position", json_of(c.error.position_m, 1, "m")},
          {"attitude", json_of(c.error.attitude_rad, rad_per_deg, "deg")},
          {"relative", relative}};
}

}  // namespace

Comparison compare(const CompareOptions& options) {
  Comparison out;
  const ParameterList a = read_parameters(options.a), b = read_parameters(options.b);
  const auto path_a = trajectory_of(options.a), path_b = trajectory_of(options.b);
  out.parameters.push_back({"A", "B", differences(a, b)});
  if (out.parameters.back().parameters.empty())
    throw InputError(options.b.string() + ": expected a parameter that " + options.a.string() + " has too");
  bool path_truth = false;
  for (const fs::path& file : options.truth) {
    if (file.extension() == ".json") {
      const ParameterList truth = read_truth_parameters(file);
      for (const auto& [name, list] : {std::pair<const char*, const ParameterList*>{"A", &a}, {"B", &b}}) {
        const bool has_sigmas =
            std::any_of(list->begin(), list->end(), [](const ParameterEstimate& p) { return p.sigma.has_value(); });
        if (has_sigmas) out.parameters.push_back({name, "truth", differences(*list, truth)});
      }
      continue;
    }
    const Poses truth = read_poses(file);
    path_truth = true;
    if (path_a) add_trajectory("A", "truth", *path_a, truth, options, &out);
    if (path_b) add_trajectory("B", "truth", *path_b, truth, options, &out);
  }
  if (!path_truth && path_a && path_b) add_trajectory("A", "B", *path_a, *path_b, options, &out);
  if ((options.position_m || options.attitude_rad) && out.trajectories.empty()) {
    throw InputError("compare: expected a trajectory.tum in " + options.a.string() +
                     " and something to compare it with");
  }
  for (const ParameterComparison& c : out.parameters) judge(c, options, &out);
  for (const TrajectoryComparison& c : out.trajectories) judge(c, options, &out);
  out.verdict = verdict_of(out);
  return out;
}

Json comparison_json(const Comparison& comparison, const CompareOptions& options) {
  Json json = {{"format", 1},
               {"verdict", comparison.verdict},
               {"within_tolerance", comparison.exceeded.empty()},
               {"exceeded", comparison.exceeded},
               {"A", options.a.string()},
               {"B", options.b.string()},
               {"parameters", Json::array()},
               {"trajectories", Json::array()}};
  for (const ParameterComparison& c : comparison.parameters) json["parameters"].push_back(json_of(c));
  for (const TrajectoryComparison& c : comparison.trajectories) json["trajectories"].push_back(json_of(c));
  return json;
}

}  // namespace host
