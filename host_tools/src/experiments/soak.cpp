// A day of stream through one device: 200 Hz and 10 images/s, sessions of five minutes with a second between them,
// faults in every second one. Does anything change with the hours?
#include <sys/resource.h>
#include <time.h>

#include <Eigen/Geometry>
#include <cmath>
#include <map>

#include "eigenvalues.h"
#include "experiments/registry.h"
#include "experiments/soak_sessions.h"
#include "experiments/statistics.h"
#include "replay/replay.h"
#include "simulate/device.h"

namespace host::experiments {
namespace {

constexpr double pause_s = 1;  // between sessions
constexpr int parts = 12;

double cpu_ms() {
  timespec t{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return 1e3 * static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_nsec);
}

/// kB that the process has held at most.
double peak_kb() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss);
}

/// What is compared between the hours.
struct Part {
  std::vector<double> frame_ms, score_ms, calibrate_ms, log10_condition, tilt_mrad, speed_mm_s;
  std::vector<double> squares[2];  ///< (error / sigma)^2 of released entries; of sessions without, with faults
  int sessions[2] = {0, 0}, calibrated[2] = {0, 0}, wrong[2] = {0, 0};
};

class Soak {
 public:
  explicit Soak(const Json& p)
      : seed_(p.at("seed")),
        session_s_(p.at("session_s")),
        sessions_(static_cast<int>(std::lround(p.at("hours").get<double>() * 3600 / session_s_))) {
    const SimulationResult first = soak_session(seed_, 0, session_s_);
    CoreOptions options;
    options.calibration = first.nominal;
    options.noise = first.recording.imu.noise;
    options.trigger_fraction = 0.3;
    core_ = make_core(p.at("profile"), options);
  }

  Json run() {
    double first_peak = 0;
    for (int i = 0; i < sessions_; ++i) {
      const SimulationResult session = soak_session(seed_, i, session_s_);
      if (i > 0) core_->new_session();
      Part& part = parts_[i * parts / sessions_];
      feed(session, i % 2 == 0, &part);
      judge(session.truth, i % 2, &part);
      if (i == 1) first_peak = peak_kb();
    }
    Json out = {
        {"peak_kb_first", first_peak}, {"peak_kb", peak_kb()}, {"parts", Json::array()}, {"counters", Json::object()}};
    for (const auto& [name, count] : core_->counters())
      if (count > 0) out["counters"][name] = count;
    for (int i = 0; i < parts; ++i) {
      out["parts"].push_back(said(parts_[i]));
      out["parts"].back()["part"] = i;
    }
    return out;
  }

 private:
  void feed(const SimulationResult& session, bool clean, Part* part) {
    const std::vector<ImuSample>& samples = session.recording.imu.samples;
    const std::vector<RigFrame> frames = rig_frames(session.recording);
    const std::int64_t shift = begin_ns_ - samples.front().t_ns;
    std::size_t sample = 0, frame = 0;
    double ms = 0;
    for (const DeviceCall& call : calls_of(session.recording, frames)) {
      const double start = cpu_ms();
      if (call.what == DeviceCall::sample) {
        ImuSample s = samples[sample++];
        s.t_ns += shift;
        core_->push_imu(s);
        ms += cpu_ms() - start;
        continue;
      }
      const RigFrame& f = frames[frame++];
      core_->push_frame(f.t_ns + shift, f.cameras);
      part->frame_ms.push_back(ms + cpu_ms() - start);
      ms = 0;
      const double work = cpu_ms();
      core_->background();
      CoreSegment segment;
      if (core_->last_segment(&segment)) part->score_ms.push_back(cpu_ms() - work);
      if (clean && frame % 10 == 0) compare(session, shift, part);
    }
    begin_ns_ += static_cast<std::int64_t>((session_s_ + pause_s) * 1e9);
  }

  /// What no frame of reference is needed for: tilt and speed.
  void compare(const SimulationResult& session, std::int64_t shift, Part* part) const {
    CoreState x;
    if (!core_->state(&x)) return;
    const sim::BodyState truth = session.state_at(x.t_ns - shift).body;
    const Eigen::Quaterniond q(x.q_GI_wxyz[0], x.q_GI_wxyz[1], x.q_GI_wxyz[2], x.q_GI_wxyz[3]);
    const Eigen::Vector3d down = q.inverse() * Eigen::Vector3d::UnitZ(),
                          true_down = truth.R_GI.transpose() * Eigen::Vector3d::UnitZ();
    part->tilt_mrad.push_back(1e3 * down.cross(true_down).norm());
    part->speed_mm_s.push_back(1e3 * std::abs(x.v_GI.norm() - truth.v_GI.norm()));
  }

  void judge(const Calibration& truth, int faults, Part* part) {
    core_->flush();
    const double start = cpu_ms();
    const bool calibrated = core_->calibrate();
    part->calibrate_ms.push_back(cpu_ms() - start);
    ++part->sessions[faults];
    const CoreResult result = core_->result();
    if (!calibrated || result.status != "calibrated") return;
    ++part->calibrated[faults];
    std::map<std::string, double> values;
    for (const sim::NamedParameter& p : sim::named_parameters(truth, true)) values[p.name] = p.value;
    bool wrong = false;
    for (const CoreParameter& p : result.parameters) {
      if (p.verdict == "fixed") continue;
      const double z = (p.value - values.at(p.name)) / p.sigma;
      part->squares[faults].push_back(z * z);
      wrong = wrong || !(std::abs(z) <= wrong_sigmas);
    }
    part->wrong[faults] += wrong ? 1 : 0;
    note_condition(result, part);
  }

  /// Of the posterior covariance in units of the prior: its square root is that of the last triangle.
  static void note_condition(const CoreResult& result, Part* part) {
    const auto n = static_cast<Eigen::Index>(result.parameters.size());
    if (result.covariance.size() != static_cast<std::size_t>(n * n)) return;
    Eigen::MatrixXd C(n, n);
    for (Eigen::Index i = 0; i < n; ++i)
      for (Eigen::Index j = 0; j < n; ++j)
        C(i, j) = result.covariance[static_cast<std::size_t>(i * n + j)] /
                  (result.parameters[static_cast<std::size_t>(i)].prior_sigma *
                   result.parameters[static_cast<std::size_t>(j)].prior_sigma);
    const Eigen::VectorXd eigenvalues = eigenvalues_of(C);
    part->log10_condition.push_back(0.5 * std::log10(eigenvalues(n - 1) / eigenvalues(0)));
  }

  static Json said(const Part& p) {
    Json out = {{"frames", p.frame_ms.size()},
                {"frame_ms", median(p.frame_ms)},
                {"frame_ms_most", quantile(p.frame_ms, 0.999)},
                {"score_ms", median(p.score_ms)},
                {"calibrate_ms", median(p.calibrate_ms)},
                {"log10_condition", median(p.log10_condition)},
                {"tilt_mrad", median(p.tilt_mrad)},
                {"speed_mm_s", median(p.speed_mm_s)}};
    for (int faults = 0; faults < 2; ++faults) {
      const char* const name = faults ? "with_faults" : "clean";
      double sum = 0;
      for (const double square : p.squares[faults]) sum += square;
      out[name] = {{"sessions", p.sessions[faults]},
                   {"calibrated", p.calibrated[faults]},
                   {"wrong", p.wrong[faults]},
                   {"sum_of_squares", sum},
                   {"entries", p.squares[faults].size()}};
    }
    return out;
  }

  std::uint64_t seed_;
  double session_s_;
  int sessions_;
  std::unique_ptr<Core> core_;
  std::int64_t begin_ns_ = 1000000000;
  Part parts_[parts];
};

}  // namespace

std::vector<Cell> soak_cells(const StudyOptions& options) {
  const int seeds = options.seeds > 0 ? options.seeds : 1;
  const double hours = options.quick ? 2 : 24;
  std::vector<Cell> cells;
  for (int i = 0; i < seeds; ++i) {
    const std::uint64_t seed = options.seed + static_cast<std::uint64_t>(i);
    for (const char* profile : {"mobile", "mcu"})
      cells.push_back({std::string(profile) + "_seed" + std::to_string(seed),
                       {{"profile", profile}, {"hours", hours}, {"session_s", 300}, {"seed", seed}}});
  }
  return cells;
}

Json soak_run(const Json& parameters) { return Soak(parameters).run(); }

}  // namespace host::experiments
