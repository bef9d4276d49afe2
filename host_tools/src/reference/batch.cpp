// Full batch over whole recordings: every keyframe of a grid and every track, in one problem per device.
#include <algorithm>
#include <map>

#include "reference/finish.h"

namespace host {
namespace reference {
namespace {

/// Weak priors and robust limit, stated apart from the core's (lib/src/segments/weights.h has the reasons).
CoreModel model_of(const ReferenceOptions& options) {
  CoreModel m;
  m.gyro_noise_density = options.noise.gyro_noise_density;
  m.gyro_random_walk = options.noise.gyro_random_walk;
  m.accel_noise_density = options.noise.accel_noise_density;
  m.accel_random_walk = options.noise.accel_random_walk;
  m.gravity = 9.80665;
  m.pixel_sigma = options.pixel_sigma;
  m.huber = 3;
  m.bias_a_sigma = 1;
  m.bias_g_sigma = 0.5;
  m.velocity_sigma = 30;
  m.inverse_depth_sigma = 5;
  return m;
}

/// A replay that keeps what it can and calibrates from it: path and theta to start from, and the prior.
ReplayResult first_estimate(const Recording& session, const ReferenceOptions& options) {
  ReplayOptions replay_options;
  replay_options.profile = "host";
  replay_options.core.calibration = options.calibration;
  replay_options.core.noise = options.noise;
  replay_options.core.pixel_sigma = options.pixel_sigma;
  replay_options.core.segments = 64;
  return replay({session}, replay_options);
}

/// Stretches of the path in which the filter did not start anew: its frames follow each other.
std::vector<std::vector<CoreState>> unbroken(const std::vector<CoreState>& path, double longest_s) {
  std::vector<std::vector<CoreState>> out;
  for (const CoreState& x : path) {
    if (out.empty() || x.t_ns - out.back().back().t_ns > static_cast<std::int64_t>(longest_s * 1e9)) out.emplace_back();
    out.back().push_back(x);
  }
  return out;
}

class Builder {
 public:
  Builder(Problem* problem, const ReferenceOptions& options) : problem_(*problem), options_(options) {}

  /// Adds a session: each unbroken stretch of its path is a chain with a frame of its own; biases walk on between them.
  void add(const Recording& session, const std::vector<CoreState>& path) {
    problem_.samples.push_back(clean(session.imu.samples));
    int before = -1;
    for (const std::vector<CoreState>& stretch : unbroken(path, 1.0)) {
      const std::vector<CoreState> keyframes = on_grid(stretch);
      if (keyframes.size() < 4) continue;
      const int first = static_cast<int>(problem_.states.size());
      for (const CoreState& x : keyframes) problem_.states.push_back(state_of(x));
      add_motion(first, before);
      add_points(session, keyframes, first);
      before = static_cast<int>(problem_.states.size()) - 1;
    }
  }

 private:
  /// Only what a device takes: finite, and later than the sample before.
  static std::vector<ImuSample> clean(const std::vector<ImuSample>& samples) {
    std::vector<ImuSample> out;
    for (const ImuSample& s : samples) {
      double sum = 0;
      for (std::size_t i = 0; i < 3; ++i) sum += s.gyro[i] + s.accel[i];
      if (std::isfinite(sum) && (out.empty() || s.t_ns > out.back().t_ns)) out.push_back(s);
    }
    return out;
  }

  /// The states nearest to a grid, as the device chooses its keyframes.
  std::vector<CoreState> on_grid(const std::vector<CoreState>& stretch) const {
    std::vector<CoreState> out;
    const auto spacing = static_cast<std::int64_t>(options_.keyframe_interval_s * 1e9);
    const std::vector<ImuSample>& samples = problem_.samples.back();
    std::int64_t due = stretch.front().t_ns;
    for (const CoreState& x : stretch) {
      if (x.t_ns + spacing / 4 < due || x.t_ns < samples.front().t_ns || x.t_ns > samples.back().t_ns) continue;
      out.push_back(x);
      due = std::max(due + spacing, x.t_ns + spacing / 2);
    }
    return out;
  }

  void add_motion(int first, int before) {
    const int samples = static_cast<int>(problem_.samples.size()) - 1, end = static_cast<int>(problem_.states.size());
    problem_.gauges.push_back(first);
    problem_.segment_starts.push_back(first);
    if (before < 0) problem_.chain_starts.push_back(first);
    if (before >= 0) problem_.walks.push_back({before, first, 1e-9 * static_cast<double>(time(first) - time(before))});
    for (int k = first + 1; k < end; ++k) problem_.links.push_back({k - 1, k, samples});
  }

  std::int64_t time(int state) const { return problem_.states[static_cast<std::size_t>(state)].t_ns; }

  void add_points(const Recording& session, const std::vector<CoreState>& keyframes, int first) {
    std::map<std::uint32_t, std::vector<Point>> tracks;
    for (std::size_t c = 0; c < session.cameras.size(); ++c) {
      for (const Frame& frame : session.cameras[c].frames) {
        const auto at = std::lower_bound(keyframes.begin(), keyframes.end(), frame.t_ns,
                                         [](const CoreState& x, std::int64_t t) { return x.t_ns < t; });
        if (at == keyframes.end() || at->t_ns != frame.t_ns) continue;
        for (const TrackPoint& z : frame.points) {
          if (!std::isfinite(z.u + z.v)) continue;
          tracks[z.track_id].push_back(
              {first + static_cast<int>(at - keyframes.begin()), 0, static_cast<int>(c), {z.u, z.v}, false});
        }
      }
    }
    for (auto& [id, points] : tracks) {
      if (points.size() < 3) continue;
      for (Point& z : points) {
        z.landmark = static_cast<int>(problem_.landmarks.size());
        problem_.points.push_back(z);
      }
      problem_.landmarks.emplace_back();
    }
  }

  Problem& problem_;
  const ReferenceOptions& options_;
};

}  // namespace
}  // namespace reference

ReferenceResult reference_batch(const std::vector<Recording>& sessions, const ReferenceOptions& options) {
  using namespace reference;
  reference::Problem problem;  // host::Problem is what segcal diagnose solves
  problem.model = model_of(options);
  problem.prior_mean = problem.theta = options.calibration;
  Builder builder(&problem, options);
  for (const Recording& session : sessions) {
    if (options.progress) options.progress("first estimate by a replay: " + session.root.string());
    const ReplayResult replay = first_estimate(session, options);
    if (replay.result.parameters.empty())
      throw InputError(session.root.string() + ": the odometry finds no path in it");
    problem.prior_sigma.clear();
    for (const CoreParameter& p : replay.result.parameters) problem.prior_sigma.push_back(p.prior_sigma);
    if (replay.result.status == "calibrated") problem.theta = replay.calibration;
    builder.add(session, replay.trajectory);
  }
  if (problem.states.empty()) throw InputError("the odometry finds no path in these recordings");
  if (options.progress) {
    options.progress(std::to_string(problem.states.size()) + " keyframes, " + std::to_string(problem.landmarks.size()) +
                     " landmarks, " + std::to_string(problem.points.size()) + " image points");
  }
  triangulate(&problem);
  // Once roughly, then without the corners that are far off although the model fits.
  SolveOptions rough;
  rough.threads = options.threads;
  rough.progress = options.progress;
  rough.rounds = 1;
  rough.iterations = 15;
  const Fit fit = solve(&problem, rough);
  reject_outliers(&problem, 5 * std::sqrt(std::max(1.0, fit.chi2 / fit.dof)));
  ReferenceResult out = finish(&problem, options);
  out.noise = options.noise;
  return out;
}

}  // namespace host
