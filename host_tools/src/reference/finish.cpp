#include "reference/finish.h"

#include "files/output_run.h"
#include "reference/judged.h"
#include "replay/result_files.h"

namespace host {
namespace reference {

State state_of(const CoreState& x) {
  const Eigen::Vector4d& q = x.q_GI_wxyz;
  return {x.t_ns, Eigen::Quaterniond(q(0), q(1), q(2), q(3)).normalized(), x.p_GI, x.v_GI, x.b_a, x.b_g};
}

CoreState core_state_of(const State& x) {
  return {x.t_ns, {x.q_GI.w(), x.q_GI.x(), x.q_GI.y(), x.q_GI.z()}, x.p_GI, x.v_GI, x.b_a, x.b_g};
}

ReferenceResult finish(Problem* problem, const ReferenceOptions& options) {
  SolveOptions solve_options;
  solve_options.threads = options.threads;
  solve_options.progress = options.progress;
  Fit fit = solve(problem, solve_options);
  if (options.progress) options.progress("covariance");
  fit.covariance = theta_covariance(*problem, options.threads);
  ReferenceResult out;
  out.result = judged(problem, fit, solve_options);
  out.calibration = problem->theta;
  for (const State& x : problem->states) out.trajectory.push_back(core_state_of(x));
  return out;
}

}  // namespace reference

void write_reference_files(const std::filesystem::path& dir, const ReferenceResult& reference) {
  ReplayResult as_replay;
  as_replay.result = reference.result;
  as_replay.calibration = reference.calibration;
  as_replay.noise = reference.noise;
  OutputRun run(dir, "reference");
  write_camchain(dir / "camchain-imucam.yaml", reference.calibration);
  write_imu_yaml(dir / "imu.yaml", reference.calibration, reference.noise);
  write_file(dir / "trajectory.tum", trajectory_tum(reference.trajectory));
  nlohmann::ordered_json json = result_json(as_replay);
  for (const char* name : {"segments", "timing", "memory", "faults", "noise"}) json.erase(name);
  write_file(dir / "result.json", json.dump(1) + "\n");
  run.finish();
}

}  // namespace host
