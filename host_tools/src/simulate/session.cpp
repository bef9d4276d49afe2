#include "session.h"

#include <algorithm>

#include "random.h"
#include "scenarios.h"

namespace host::sim {
namespace {

constexpr double fit_margin = 0.35;          // s at the ends of a fitted trajectory that are left out
constexpr double replica_knot_step = 0.025;  // s: hands shake at up to 10 Hz, and samples show it
constexpr std::int64_t epoch_ns = 1700000000000000000;

Session drawn_session(const SimulationOptions& options) {
  Random random(options.seed, Stream::clock);
  Session session;
  session.trajectory = make_trajectory(options.scenario, options.seconds, options.seed);
  session.time_zero_ns = epoch_ns + static_cast<std::int64_t>(random.uniform(0, 1e15));
  session.last_frame = options.seconds;
  return session;
}

Session recorded_session(const SimulationOptions& options) {
  // Real IMU samples hold fast motion that the poses must follow; simulated ones only need a plausible motion.
  const double knot_step = options.imu_file.empty() ? 0.1 : 0.05;
  FittedTrajectory fit = fit_trajectory(options.trajectory_file, knot_step);
  Session session;
  session.time_zero_ns = fit.first_pose_ns;
  session.first_frame = fit_margin;
  session.last_frame = std::min(fit_margin + options.seconds, fit.trajectory.last_time() - fit_margin);
  session.trajectory = std::move(fit.trajectory);
  // Across a hole the fit is a guess: a motion as good as any other for simulated samples, but wrong for real ones.
  if (!options.imu_file.empty()) session.holes = std::move(fit.holes);
  return session;
}

Session replica_session(const Replica& replica) {
  Session session;
  session.trajectory = fit_trajectory(replica.poses, "twin", replica_knot_step).trajectory;
  session.time_zero_ns = replica.poses.first_ns;
  session.first_frame = fit_margin;
  session.last_frame = replica.poses.t.back() - fit_margin;
  return session;
}

}  // namespace

bool Session::in_hole(double t) const {
  return std::any_of(holes.begin(), holes.end(), [t](const Hole& hole) { return t > hole.begin && t < hole.end; });
}

Session session_of(const SimulationOptions& options) {
  if (options.replica) return replica_session(*options.replica);
  return options.trajectory_file.empty() ? drawn_session(options) : recorded_session(options);
}

}  // namespace host::sim
