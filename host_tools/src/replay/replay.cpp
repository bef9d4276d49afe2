#include "replay/replay.h"

#include <algorithm>
#include <chrono>

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

/// The images of all cameras at one stamp; null: this camera has none.
struct RigFrame {
  std::int64_t t_ns = 0;
  std::vector<const Frame*> cameras;
};

/// In the order of the log, so that stamps that repeat or go back reach the core, which counts them. Cameras of one rig
/// share their trigger: a frame joins the one of cam0 with the same stamp, or stands before the first later one.
std::vector<RigFrame> rig_frames(const Recording& recording) {
  const std::size_t n = recording.cameras.size();
  std::vector<RigFrame> out;
  for (const Frame& frame : recording.cameras[0].frames) {
    out.push_back({frame.t_ns, std::vector<const Frame*>(n, nullptr)});
    out.back().cameras[0] = &frame;
  }
  for (std::size_t c = 1; c < n; ++c) {
    std::size_t at = 0;
    for (const Frame& frame : recording.cameras[c].frames) {
      while (at < out.size() && (out[at].t_ns < frame.t_ns || (out[at].t_ns == frame.t_ns && out[at].cameras[c]))) ++at;
      if (at == out.size() || out[at].t_ns != frame.t_ns) {
        out.insert(out.begin() + static_cast<std::ptrdiff_t>(at), {frame.t_ns, std::vector<const Frame*>(n, nullptr)});
      }
      out[at].cameras[c] = &frame;
    }
  }
  return out;
}

class Session {
 public:
  /// `background`: the device works in the background as in firmware, and so calibrates when it knows enough.
  Session(Core& core, ReplayResult& out, bool background) : core_(core), out_(out), background_(background) {}

  void run(const Recording& recording, const std::function<void(double)>& progress) {
    const std::vector<RigFrame> frames = rig_frames(recording);
    auto next = recording.imu.samples.begin();
    const auto end = recording.imu.samples.end();
    std::size_t done = 0;
    for (const RigFrame& frame : frames) {
      // The filter wants IMU samples up to the frame: a real device sees the image later than the samples around it.
      const auto start = Clock::now();
      bool reached = false;
      while (next != end && !reached) {
        reached = next->t_ns >= frame.t_ns;
        core_.push_imu(*next++);
      }
      take_frame(frame, start);
      if (progress) progress(static_cast<double>(++done) / frames.size());
    }
    core_.flush();
    collect_segment();
    if (background_ && core_.background()) note_calibration(true);
  }

  void note_calibration(bool by_targets) {
    const CoreResult result = core_.result();
    out_.calibrations.push_back({newest_, by_targets, result.segments, result.status, result.parameters});
    for (CoreSegment& s : out_.segments) {
      for (std::uint32_t serial : core_.outdated()) s.outdated |= s.serial == serial;
    }
  }

  std::vector<double> frame_ms, score_ms;

 private:
  void take_frame(const RigFrame& frame, Clock::time_point start) {
    const FrameOutcome outcome = core_.push_frame(frame.t_ns, frame.cameras);
    newest_ = frame.t_ns;
    const double ms = ms_since(start);
    if (collect_segment()) {
      score_ms.push_back(ms);
    } else if (outcome == FrameOutcome::tracking) {
      frame_ms.push_back(ms);
    }
    CoreState state;
    if (outcome == FrameOutcome::tracking && core_.state(&state)) out_.trajectory.push_back(state);
    if (background_ && core_.background()) note_calibration(true);
  }

  bool collect_segment() {
    CoreSegment segment;
    if (!core_.last_segment(&segment)) return false;
    out_.segments.push_back(segment);
    return true;
  }

  Core& core_;
  ReplayResult& out_;
  bool background_;
  std::int64_t newest_ = 0;
};

void mark_kept(ReplayResult& out) {
  for (CoreSegment& s : out.segments) {
    s.kept = std::any_of(out.kept.begin(), out.kept.end(), [&s](const CoreKept& k) { return k.segment.serial == s.serial; });
  }
}

}  // namespace

ReplayResult replay(const std::vector<Recording>& sessions, const ReplayOptions& options) {
  CoreOptions core_options = options.core;
  core_options.joint_ekf = options.joint_ekf;
  std::unique_ptr<Core> core = make_core(options.profile, core_options);
  ReplayResult out;
  out.noise = options.core.noise;
  Session session(*core, out, options.calibrate && options.core.trigger_fraction > 0);
  for (std::size_t i = 0; i < sessions.size(); ++i) {
    if (i > 0) core->new_session();
    session.run(sessions[i], options.progress);
    if (!options.calibrate) continue;
    const auto start = Clock::now();
    out.calibrated = core->calibrate() || out.calibrated;
    out.timing.calibrate_ms = ms_since(start);
    session.note_calibration(false);
    if (options.after_session) options.after_session(i, core->result(), core->calibration());
  }
  out.result = core->result();
  out.calibration = core->calibration();
  out.kept = core->kept();
  out.model = core->model();
  out.start = options.core.calibration;
  out.counters = core->counters();
  out.memory = core->memory();
  out.timing.vio_ms_median = quantile(session.frame_ms, 0.5);
  out.timing.vio_ms_p95 = quantile(session.frame_ms, 0.95);
  out.timing.score_ms_median = quantile(session.score_ms, 0.5);
  mark_kept(out);
  if (options.keep_core) *options.keep_core = std::move(core);
  return out;
}

}  // namespace host
