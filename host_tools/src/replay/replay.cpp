#include "replay/replay.h"

#include <algorithm>
#include <chrono>

#include "quantile.h"
#include "replay/begin_device.h"
#include "replay/config_file.h"
#include "replay/counters.h"
#include "replay/temperature_use.h"
#include "review/joint_filter.h"
#include "review/review.h"
#include "review/unseen_effects.h"

namespace host {
namespace {

using Clock = std::chrono::steady_clock;

double ms_since(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

/// ms; 0 where there was none.
double share_of_times(const std::vector<double>& ms, double q) { return ms.empty() ? 0 : quantile(ms, q); }

class Session {
 public:
  Session(Core& core, ReplayResult& out, bool calibrate) : core_(core), out_(out), calibrate_(calibrate) {}

  void run(const Recording& recording, const std::function<void(double)>& progress) {
    const std::vector<RigFrame> frames = rig_frames(recording);
    std::size_t sample = 0, frame = 0;
    auto start = Clock::now();
    core_.work_ahead(!recording.device || !recording.device->was_late);
    for (const DeviceCall& call : calls_of(recording, frames)) {
      if (call.late) core_.be_late(true);
      switch (call.what) {
        case DeviceCall::sample: core_.push_imu(recording.imu.samples[sample++]); break;
        case DeviceCall::frame:
          take_frame(frames[frame++], start);
          if (progress) progress(static_cast<double>(frame) / frames.size());
          break;
        case DeviceCall::flush: flush(); break;
        case DeviceCall::calibrate: calibrate(); break;
        case DeviceCall::request: core_.request_calibration(); break;
        case DeviceCall::hash: out_.hash_checks.push_back({call.hash_value, core_.result_hash()}); break;
      }
      if (call.late) core_.be_late(false);
      if (call.what == DeviceCall::sample) continue;  // its time counts with its frame's
      start = Clock::now();
    }
  }

  /// What was gathered so far is of a pass that another one follows.
  void begin_pass() {
    out_.segments.clear();
    out_.trajectory.clear();
    out_.calibrations.clear();
    out_.hash_checks.clear();
    out_.health.frames_offered = 0;
    out_.calibrated = false;
    frame_ms.clear();
    score_ms.clear();
  }

  void flush() {
    core_.flush();
    collect_segment();
    if (core_.background()) note_calibration(true);
  }

  void calibrate() {
    if (!calibrate_) return;
    const auto start = Clock::now();
    out_.calibrated = core_.calibrate() || out_.calibrated;
    out_.timing.calibrate_ms = ms_since(start);
    note_calibration(false);
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
    if (outcome != FrameOutcome::skipped) ++out_.health.frames_offered;
    const bool calibrated = core_.background();
    const double ms = ms_since(start);
    // An image that waited for its IMU samples was processed by now; the newest one may wait.
    CoreState state;
    const bool tracked = core_.state(&state) && state.t_ns != newest_state_;
    if (collect_segment()) {
      score_ms.push_back(ms);
    } else if (tracked) {
      frame_ms.push_back(ms);
    }
    if (tracked) {
      newest_state_ = state.t_ns;
      out_.trajectory.push_back(state);
    }
    if (calibrated) note_calibration(true);
  }

  bool collect_segment() {
    CoreSegment segment;
    if (!core_.last_segment(&segment)) return false;
    out_.segments.push_back(segment);
    return true;
  }

  Core& core_;
  ReplayResult& out_;
  bool calibrate_;
  std::int64_t newest_ = 0, newest_state_ = INT64_MIN;
};

void mark_kept(ReplayResult& out) {
  for (CoreSegment& s : out.segments) {
    s.kept =
        std::any_of(out.kept.begin(), out.kept.end(), [&s](const CoreKept& k) { return k.segment.serial == s.serial; });
  }
}

/// Whether a session ends with a calibration: as the device did it, but a log without any has one at its end.
bool calibrates_at_end(const Recording& recording) {
  if (!recording.device) return true;
  const std::vector<DeviceCall>& calls = recording.device->calls;
  const auto is = [](DeviceCall::What what) { return [what](const DeviceCall& call) { return call.what == what; }; };
  return recording.device->last && std::any_of(calls.begin(), calls.end(), is(DeviceCall::frame)) &&
         std::none_of(std::find_if(calls.rbegin(), calls.rend(), is(DeviceCall::frame)).base(), calls.end(),
                      is(DeviceCall::calibrate));
}

/// One pass over all recordings.
void run_all(const std::vector<Recording>& sessions, const ReplayOptions& options, bool goes_on, Core* core,
             Session* session) {
  for (std::size_t i = 0; i < sessions.size(); ++i) {
    if (i > 0 || goes_on) core->new_session();
    if (i > 0) expect_left_state(sessions[i], options, core);
    session->run(sessions[i], options.progress);
    const bool left_as_is = i + 1 < sessions.size() && begins_with_state(sessions[i + 1]);
    if (!left_as_is && calibrates_at_end(sessions[i])) {
      session->flush();
      session->calibrate();
    }
    if (!options.calibrate) continue;
    if (options.after_session) options.after_session(i, core->result(), core->calibration());
  }
}

/// `out` is of the pass before but for what Session gathers.
ReplayPass pass_of(const ReplayResult& out, const Counters& counters, const Core& core) {
  const CoreResult now = core.result();
  ReplayPass pass;
  pass.status = out.calibrated ? now.status : "insufficient";
  pass.segments = out.calibrated ? now.segments : 0;
  pass.segments_scored = static_cast<int>(out.segments.size());
  pass.frames_used = count_of(counters, "frames_used");
  pass.filter_restarts = count_of(counters, "filter_restarts");
  if (!out.calibrated) return pass;
  pass.chi2_per_dof = now.dof > 0 ? now.chi2 / now.dof : 0;
  measure_step(now, out.passes.empty() ? nullptr : &out.result, &pass);
  return pass;
}

/// Sessions of passes before the last count for nothing.
void count_sessions_from(std::uint32_t first, ReplayResult* out) {
  for (CoreSegment& s : out->segments) s.session -= first;
  for (CoreKept& k : out->kept) k.segment.session -= first;
}

}  // namespace

ReplayResult replay_as_stated(const std::vector<Recording>& sessions, const ReplayOptions& options) {
  CoreOptions core_options = options.core;
  core_options.joint_ekf = options.joint_ekf;
  if (!options.calibrate) core_options.trigger_fraction = 0;
  std::unique_ptr<Core> core = make_core(options.profile, core_options);
  check_states(sessions, options);
  begin_device(sessions.front(), options, core.get());
  ReplayResult out;
  out.noise = options.core.noise;
  if (options.core.device_config.empty()) out.config = config_yaml(options.core);
  Session session(*core, out, options.calibrate);
  Counters counters_before = core->counters();
  for (int pass = 0; pass < std::max(1, options.passes); ++pass) {
    if (pass > 0) {
      if (!out.passes.back().goes_on()) break;
      counters_before = core->counters();
      session.begin_pass();
    }
    run_all(sessions, options, pass > 0, core.get(), &session);
    out.passes.push_back(pass_of(out, difference(core->counters(), counters_before), *core));
    out.result = core->result();  // measure_step compares the next pass with it
  }
  if (options.passes > 1 && !out.calibrated)
    out.result.status = "insufficient";  // the core still has the result of the pass before
  out.calibration = core->calibration();
  out.kept = core->kept();
  out.model = core->model();
  out.track_noise = estimate_track_noise(out.kept, out.calibration, out.model);
  out.start = options.core.calibration;
  out.counters = difference(core->counters(), counters_before);
  count_strays(sessions, &out.counters);
  out.memory = core->memory();
  out.result_hash = core->result_hash();
  out.timing.vio_ms_median = share_of_times(session.frame_ms, 0.5);
  out.timing.vio_ms_p95 = share_of_times(session.frame_ms, 0.95);
  out.timing.score_ms_median = share_of_times(session.score_ms, 0.5);
  count_sessions_from(static_cast<std::uint32_t>((out.passes.size() - 1) * sessions.size()), &out);
  mark_kept(out);
  if (options.state) {
    core->save(&options.state->flash);
    options.state->profile = options.profile;
  }
  out.clocks = options.clocks;
  if (options.review && options.joint_ekf) review::judge_joint_filter(sessions, options, &out);
  core_options.segments = segments_kept(options.profile, core_options.segments);
  if (options.review && !options.joint_ekf) review::review(sessions, core_options, *core, &out);
  refuse_temperature(sessions, &out);
  review::note_unseen_effects(&out);
  if (options.keep_core) *options.keep_core = std::move(core);
  return out;
}

}  // namespace host
