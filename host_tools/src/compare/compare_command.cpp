// The subcommand `segcal compare`.
#include <cstdio>
#include <iostream>
#include <memory>

#include "angles.h"
#include "commands.h"
#include "compare/compare.h"
#include "file_output.h"
#include "files/manifest.h"
#include "files/output_run.h"
#include "recording.h"

namespace host {
namespace {

constexpr const char* compare_footer = R"(Examples:
  segcal compare out1 out2
      the same device on two days: differences in units of their sigma
  segcal compare replay_out reference_out --sigma-of b --sigmas 0.05 --sigma-ratio 0.02
      two solvers on the same segments: their difference is not noise, so the reference's own sigma is the measure
  segcal compare out1 out2 --truth rec/truth/truth.json --truth rec/mav0/state_groundtruth_estimate0/data.csv --relative 1 5 10

A folder without result.json (Kalibr's own output) is read from camchain-imucam.yaml and imu.yaml, without sigmas.
Position and attitude: errors at each time after alignment. --relative: errors of the motion over stretches of path of that
length, from each pose, as evo's RPE over all pairs. Exit code 1: above a tolerance; 2: bad usage or input.)";

struct CompareArguments {
  CompareOptions options;
  std::string align = "yaw", sigma_of = "difference";
  std::filesystem::path out;
  double attitude_deg = -1, position_m = -1, sigma_ratio = -1;
  bool json = false;
};

std::string number(const std::optional<double>& value, const char* format) {
  if (!value) return "-";
  char text[32];
  std::snprintf(text, sizeof text, format, *value);
  return text;
}

void print(const ParameterComparison& c) {
  std::printf("%s against %s\n%-14s %-4s %14s %14s %12s %10s %10s %10s\n", c.of.c_str(), c.against.c_str(), "parameter",
              "unit", c.of.c_str(), c.against.c_str(), "difference", ("/sig " + c.of).c_str(),
              ("/sig " + c.against).c_str(), "/sig diff");
  for (const ParameterDifference& d : c.parameters) {
    std::printf("%-14s %-4s %14.6f %14.6f %12.2e %10s %10s %10s\n", d.name.c_str(), d.unit.c_str(), d.a, d.b,
                d.difference, number(d.in_a, "%.3f").c_str(), number(d.in_b, "%.3f").c_str(),
                number(d.in_difference, "%.3f").c_str());
  }
}

void print_row(const char* what, const Spread& s, double unit) {
  std::printf("  %-24s %10.4f %10.4f %10.4f %8zu\n", what, s.rmse / unit, s.median / unit, s.max / unit, s.n);
}

void print(const TrajectoryComparison& c) {
  std::printf("%s against %s: %.1f s, %.2f m of path, time shift %.4f s\n  %-24s %10s %10s %10s %8s\n", c.of.c_str(),
              c.against.c_str(), c.error.duration_s, c.error.path_m, c.error.time_shift_s, "", "RMSE", "median", "max",
              "poses");
  print_row("position [m]", c.error.position_m, 1);
  print_row("attitude [deg]", c.error.attitude_rad, rad_per_deg);
  for (const RelativeError& r : c.error.relative) {
    char name[48];
    std::snprintf(name, sizeof name, "over %g m: position [m]", r.segment_m);
    print_row(name, r.position_m, 1);
    std::snprintf(name, sizeof name, "over %g m: attitude [deg]", r.segment_m);
    print_row(name, r.attitude_rad, rad_per_deg);
  }
}

int run(CompareArguments a) {
  a.options.trajectory.alignment = alignment_from_name(a.align);
  a.options.sigma_of = sigma_of_from_name(a.sigma_of);
  if (a.position_m >= 0) a.options.position_m = a.position_m;
  if (a.attitude_deg >= 0) a.options.attitude_rad = a.attitude_deg * rad_per_deg;
  if (a.sigma_ratio >= 0) a.options.sigma_ratio = a.sigma_ratio;
  for (const auto& folder : {a.options.a, a.options.b}) check_folder(folder);
  const Comparison c = compare(a.options);
  const std::string json = comparison_json(c, a.options).dump(1) + "\n";
  if (!a.out.empty()) {
    OutputRun files(a.out, "compare", FolderRole::guest);
    write_file(a.out / "compare.json", json);
    files.finish();
  }
  if (a.json) {
    std::cout << json;
  } else {
    for (const ParameterComparison& p : c.parameters) print(p);
    for (const TrajectoryComparison& t : c.trajectories) print(t);
    for (const std::string& e : c.exceeded) std::printf("above tolerance: %s\n", e.c_str());
    std::printf("%s\n", c.verdict.c_str());
  }
  return c.exceeded.empty() ? 0 : 1;
}

}  // namespace

void add_compare_command(CLI::App& app, int& exit_code) {
  const auto a = std::make_shared<CompareArguments>();
  CompareOptions& o = a->options;
  CLI::App* sub = app.add_subcommand(
      "compare", "two results against each other and the truth: parameters in units of sigma, trajectories");
  sub->add_option("DIR_A", o.a, "folder that segcal wrote: result.json, trajectory.tum")->required();
  sub->add_option("DIR_B", o.b, "the other one")->required();
  sub->add_option("--truth", o.truth,
                  "truth.json of a simulation, or a trajectory: TUM, or EuRoC's data.csv; may be given twice")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  sub->add_option("--out", a->out, "folder for compare.json");
  sub->add_flag("--json", a->json, "print compare.json on standard output");
  sub->add_option("--sigmas", o.sigmas, "tolerance of each parameter, sigma")
      ->capture_default_str()
      ->check(CLI::PositiveNumber);
  sub->add_option("--sigma-of", a->sigma_of, "whose sigma: of the difference of independent results, of a, or of b")
      ->capture_default_str()
      ->check(CLI::IsMember({"difference", "a", "b"}));
  sub->add_option("--sigma-ratio", a->sigma_ratio, "tolerance of sigma_A / sigma_B - 1")->check(CLI::NonNegativeNumber);
  sub->add_option("--position-rmse", a->position_m, "tolerance, m")->check(CLI::NonNegativeNumber);
  sub->add_option("--attitude-rmse", a->attitude_deg, "tolerance, deg")->check(CLI::NonNegativeNumber);
  sub->add_option("--align", a->align, "transformation allowed between the trajectories: none, yaw (and position), se3")
      ->capture_default_str()
      ->check(CLI::IsMember({"none", "yaw", "se3"}));
  sub->add_option("--time-shift", o.trajectory.largest_shift_s,
                  "estimate a shift of the clocks within +- this, s; 0: none")
      ->capture_default_str()
      ->check(CLI::Range(0.0, 10.0));
  sub->add_option("--largest-gap", o.trajectory.largest_gap_s, "the reference is not interpolated across more, s")
      ->capture_default_str()
      ->check(CLI::PositiveNumber);
  sub->add_option("--relative", o.trajectory.segment_m, "lengths of path for the relative pose error, m")
      ->check(CLI::PositiveNumber);
  sub->footer(compare_footer);
  sub->callback([a, &exit_code] { exit_code = run(*a); });
}

}  // namespace host
