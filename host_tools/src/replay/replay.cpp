#include "replay/replay.h"

#include <algorithm>
#include <chrono>
#include <map>

namespace host {
namespace {

using Clock = std::chrono::steady_clock;

double ms_since(Clock::time_point start) { return std::chrono::duration<double, std::milli>(Clock::now() - start).count(); }

double quantile(std::vector<double> values, double q) {
  if (values.empty()) return 0;
  const std::size_t i = std::min(values.size() - 1, static_cast<std::size_t>(q * values.size()));
  std::nth_element(values.begin(), values.begin() + i, values.end());
  return values[i];
}

/// Frames of all cameras by stamp; cameras of one rig share their trigger and so their stamps.
std::map<std::int64_t, std::vector<const Frame*>> frames_by_stamp(const Recording& recording) {
  std::map<std::int64_t, std::vector<const Frame*>> out;
  for (std::size_t c = 0; c < recording.cameras.size(); ++c) {
    for (const Frame& frame : recording.cameras[c].frames) {
      auto& entry = out[frame.t_ns];
      entry.resize(recording.cameras.size(), nullptr);
      entry[c] = &frame;
    }
  }
  return out;
}

class Session {
 public:
  Session(Core& core, ReplayResult& out) : core_(core), out_(out) {}

  void run(const Recording& recording, const std::function<void(double)>& progress) {
    const auto frames = frames_by_stamp(recording);
    auto next = recording.imu.samples.begin();
    const auto end = recording.imu.samples.end();
    std::size_t done = 0;
    for (const auto& [t_ns, cameras] : frames) {
      // The filter wants IMU samples up to the frame: a real device sees the image later than the samples around it.
      const auto start = Clock::now();
      bool reached = false;
      while (next != end && !reached) {
        reached = next->t_ns >= t_ns;
        core_.push_imu(*next++);
      }
      take_frame(t_ns, cameras, start);
      if (progress) progress(static_cast<double>(++done) / frames.size());
    }
    core_.flush();
    collect_segment();
  }

  std::vector<double> frame_ms, score_ms;

 private:
  void take_frame(std::int64_t t_ns, const std::vector<const Frame*>& cameras, Clock::time_point start) {
    const FrameOutcome outcome = core_.push_frame(t_ns, cameras);
    const double ms = ms_since(start);
    if (collect_segment()) {
      score_ms.push_back(ms);
    } else if (outcome == FrameOutcome::tracking) {
      frame_ms.push_back(ms);
    }
    CoreState state;
    if (outcome == FrameOutcome::tracking && core_.state(&state)) out_.trajectory.push_back(state);
  }

  bool collect_segment() {
    CoreSegment segment;
    if (!core_.last_segment(&segment)) return false;
    out_.segments.push_back(segment);
    return true;
  }

  Core& core_;
  ReplayResult& out_;
};

void mark_kept(ReplayResult& out) {
  for (CoreSegment& s : out.segments) {
    s.kept = std::any_of(out.kept.begin(), out.kept.end(), [&s](const CoreKept& k) { return k.segment.serial == s.serial; });
  }
}

}  // namespace

ReplayResult replay(const std::vector<Recording>& sessions, const ReplayOptions& options) {
  const std::unique_ptr<Core> core = make_core(options.profile, options.core);
  ReplayResult out;
  out.noise = options.core.noise;
  Session session(*core, out);
  for (std::size_t i = 0; i < sessions.size(); ++i) {
    if (i > 0) core->new_session();
    session.run(sessions[i], options.progress);
    if (!options.calibrate) continue;
    const auto start = Clock::now();
    out.calibrated = core->calibrate() || out.calibrated;
    out.timing.calibrate_ms = ms_since(start);
  }
  out.result = core->result();
  out.calibration = core->calibration();
  out.kept = core->kept();
  out.counters = core->counters();
  out.memory = core->memory();
  out.timing.vio_ms_median = quantile(session.frame_ms, 0.5);
  out.timing.vio_ms_p95 = quantile(session.frame_ms, 0.95);
  out.timing.score_ms_median = quantile(session.score_ms, 0.5);
  mark_kept(out);
  return out;
}

}  // namespace host
