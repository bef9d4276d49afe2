// How far off may a start be? Every listed parameter is displaced by exactly k sigmas, with a random sign; what is not
// listed starts at its nominal value, as far off as the device was drawn.
#include <Eigen/Geometry>
#include <map>

#include "experiments/datasets.h"
#include "experiments/registry.h"
#include "experiments/statistics.h"
#include "replay/replay.h"
#include "simulate/random.h"

namespace host::experiments {
namespace {

constexpr double sigma_px = 1, sigma_rad = 0.001, sigma_m = 0.010, sigma_scale = 0.004;
const int factors[] = {1, 2, 3, 5};
constexpr double converged_sigmas = 5;  // 26 parameters: beyond that by chance once in 67000

Eigen::Vector3d signs(sim::Random& random) {
  Eigen::Vector3d out;
  for (int i = 0; i < 3; ++i) out(i) = random.uniform() < 0.5 ? -1 : 1;
  return out;
}

Eigen::Matrix3d turned(const Eigen::Matrix3d& R, const Eigen::Vector3d& d) {
  return Eigen::AngleAxisd(d.norm(), d.normalized()).toRotationMatrix() * R;
}

Calibration start_of(const SimulationResult& session, double k, std::uint64_t seed) {
  sim::Random random(seed, sim::Stream::device);
  Calibration start = session.nominal;
  const Calibration& truth = session.truth;
  for (std::size_t c = 0; c < start.cameras.size(); ++c) {
    const Eigen::Vector3d f = k * sigma_px * signs(random), centre = k * sigma_px * signs(random);
    start.cameras[c].intrinsics = truth.cameras[c].intrinsics + Eigen::Vector4d(f(0), f(1), centre(0), centre(1));
    start.cameras[c].R_CI = turned(truth.cameras[c].R_CI, k * sigma_rad * signs(random));
    start.cameras[c].p_CI = truth.cameras[c].p_CI + k * sigma_m * signs(random);
  }
  start.imu.R_AI = turned(truth.imu.R_AI, k * sigma_rad * signs(random));
  start.imu.T_g.diagonal() = truth.imu.T_g.diagonal() + k * sigma_scale * signs(random);
  start.imu.T_a.diagonal() = truth.imu.T_a.diagonal() + k * sigma_scale * signs(random);
  return start;
}

}  // namespace

std::vector<Cell> basin_cells(const StudyOptions& options) {
  std::vector<Cell> cells;
  const int seeds = options.quick ? 5 : 20;
  for (const char* scenario : {"rich", "arvr"}) {
    for (const int k : factors) {
      for (int i = 0; i < seeds; ++i) {
        const std::uint64_t seed = options.seed + static_cast<std::uint64_t>(i);
        const double seconds = std::string(scenario) == "rich" ? 60 : 120;
        cells.push_back({std::string(scenario) + "_x" + std::to_string(k) + "_seed" + std::to_string(seed),
                         {{"scenario", scenario}, {"factor", k}, {"seconds", seconds}, {"seed", seed}}});
      }
    }
  }
  return cells;
}

Json basin_run(const Json& parameters) {
  const SimulationResult session = simulate_cell(parameters);
  ReplayOptions options;
  options.core.calibration = start_of(session, parameters.at("factor"), parameters.at("seed"));
  options.core.noise = session.recording.imu.noise;
  const CoreResult result = replay({session.recording}, options).result;
  double worst = 0;
  std::string name;
  const Json table = parameters_json(result, session.truth);
  for (const Json& p : table) {
    if (p.at("verdict") != "observed") continue;
    const double error =
        std::abs(p.at("value").get<double>() - p.at("truth").get<double>()) / p.at("sigma").get<double>();
    if (error <= worst) continue;
    worst = error;
    name = p.at("name");
  }
  return {{"status", result.status},
          {"iterations", result.iterations},
          {"chi2_per_dof", result.dof > 0 ? result.chi2 / result.dof : 0},
          {"worst_error_per_sigma", worst},
          {"worst_parameter", name},
          {"converged", result.status == "calibrated" && worst < converged_sigmas}};
}

Findings basin_gather(const std::vector<CellResult>& cells) {
  struct Group {
    int n = 0, converged = 0;
    std::vector<double> worst, iterations, fit;
    std::string failed;
  };
  std::map<std::pair<std::string, int>, Group> groups;
  Findings out;
  Table all{"Every start",
            "",
            {{"scenario", ""},
             {"start", "sigma"},
             {"seed", "-"},
             {"status", ""},
             {"iterations", "-"},
             {"chi2/dof", "-"},
             {"largest error of an observed parameter", "sigma"},
             {"of", ""},
             {"converged", ""}},
            {}};
  for (const CellResult& c : cells) {
    Group& g = groups[{c.parameters.at("scenario"), c.parameters.at("factor")}];
    ++g.n;
    g.converged += c.result.at("converged").get<bool>();
    if (!c.result.at("converged").get<bool>()) g.failed += " " + c.parameters.at("seed").dump();
    g.worst.push_back(c.result.at("worst_error_per_sigma"));
    g.iterations.push_back(c.result.at("iterations"));
    g.fit.push_back(c.result.at("chi2_per_dof"));
    all.rows.push_back({c.parameters.at("scenario"), c.parameters.at("factor"), c.parameters.at("seed"),
                        c.result.at("status"), c.result.at("iterations"), c.result.at("chi2_per_dof"),
                        c.result.at("worst_error_per_sigma"), c.result.at("worst_parameter"),
                        c.result.at("converged")});
  }
  Table table{"Convergence",
              "Converged: calibrated, and every observed parameter within 5 sigma of the truth. One sigma: f, c 1 px, "
              "rotations 1 mrad, lever arm 10 mm, scales 0.004. A time offset is not a parameter of this core and is "
              "not displaced.",
              {{"scenario", ""},
               {"start", "sigma"},
               {"starts", "-"},
               {"converged", "-"},
               {"median iterations", "-"},
               {"median chi2/dof", "-"},
               {"median of largest error", "sigma"},
               {"seeds that did not", ""}},
              {}};
  Figure figure{"Converged starts", "lines", "start [sigma]", "share converged [-]", false, {}};
  std::map<std::string, Series> lines;
  for (const auto& [key, g] : groups) {
    table.rows.push_back(
        {key.first, key.second, g.n, g.converged, median(g.iterations), median(g.fit), median(g.worst), g.failed});
    lines[key.first].x.push_back(key.second);
    lines[key.first].y.push_back(static_cast<double>(g.converged) / g.n);
    if (key.second == 5) {
      out.limits.push_back({"converged of " + std::to_string(g.n) + " at 5 sigmas, " + key.first,
                            static_cast<double>(g.converged), static_cast<double>(g.n), "-", true});
    }
  }
  for (auto& [name, line] : lines) {
    line.name = name;
    figure.series.push_back(line);
  }
  out.tables = {table, all};
  out.figures = {figure};
  return out;
}

}  // namespace host::experiments
