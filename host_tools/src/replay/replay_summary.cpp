#include "replay/replay_summary.h"

#include <unistd.h>

#include <cstdio>
#include <iostream>

#include "replay/words.h"

namespace host {
namespace {

/// "5 of 12 segments kept, 30 in epochs"; those of a state's earlier sessions are not among the 12.
std::string words_on_segments(const ReplayResult& r, bool went_on) {
  int condensed = 0;
  for (const CoreEpoch& e : r.result.epochs) condensed += e.segments;
  const std::string kept = std::to_string(r.result.segments), scored = std::to_string(r.segments.size());
  return (went_on ? kept + " segments kept, " + scored + " scored in this run"
                  : kept + " of " + scored + " segments kept") +
         (condensed > 0 ? ", " + std::to_string(condensed) + " in epochs" : "");
}

}  // namespace

void show_replay_progress(double fraction) {
  static int last = -1;
  const bool terminal = isatty(STDERR_FILENO) != 0;
  const int step = terminal ? 1 : 25, percent = static_cast<int>(100 * fraction) / step * step;
  if (percent == last) return;
  last = percent;
  std::cerr << (terminal ? "\r" : "") << "replay " << percent << " %" << (!terminal || percent == 100 ? "\n" : "")
            << std::flush;
}

void print_replay_summary(const ReplayResult& r, bool went_on) {
  const CoreResult& c = r.result;
  for (std::size_t i = 0; r.passes.size() > 1 && i < r.passes.size(); ++i)
    std::printf("%s\n", in_words(r.passes[i], i + 1).c_str());
  if (!r.cause.empty()) std::printf("not calibrated: %s\n", r.cause.c_str());
  for (const Suspect& s : r.health.suspects) {
    if (r.cause.find(s.words) == std::string::npos)
      std::printf("suspect: %s%s\n", s.words.c_str(), s.in_sigmas ? "; the sigmas hold what it would move" : "");
  }
  for (const Note& n : r.health.notes) {
    if (r.cause.find(n.words) == std::string::npos) std::printf("note: %s\n", n.words.c_str());
  }
  if (r.weighed_by_tracks)
    std::printf(
        "note: corners are weighed by the noise that their tracks show in a first replay, or 0.1 px after a "
        "second: %.2g px and %.2g px/sqrt(s); --pixel-sigma states another\n",
        r.model.pixel_sigma, r.model.track_walk);
  const std::vector<std::string> names = parameter_names(c, r.calibration);
  for (const CoreChange& change : c.changes) {
    if (!change.open || r.cause.empty()) std::printf("note: %s\n", change_words(change, c).c_str());
  }
  const std::string course = course_words(c);
  if (!course.empty() && r.cause.find(course) == std::string::npos) std::printf("note: %s\n", course.c_str());
  std::printf("%s: %s, chi2/dof %.3f, reprojection rms %.2f px (median %.2f px), %d iterations\n", c.status.c_str(),
              words_on_segments(r, went_on).c_str(), c.dof > 0 ? c.chi2 / c.dof : 0.0, c.reprojection_rms_px,
              c.reprojection_median_px, c.iterations);
  for (const ReplayCalibration& done : r.calibrations) {
    if (done.by_targets)
      std::printf("targets reached at %.2f s with %d segments: %s\n", 1e-9 * static_cast<double>(done.t_ns),
                  done.segments, done.status.c_str());
  }
  std::printf("%-26s %14s %12s %-10s %14s  %s\n", "parameter", "value", "sigma", "unit", "initial", "verdict");
  for (const CoreParameter& p : c.parameters) {
    std::printf("%-26s %14.7g %12.3g %-10s %14.7g  %s\n", p.name.c_str(), p.value, p.sigma, p.unit.c_str(), p.initial,
                p.verdict.c_str());
  }
  for (const CoreDirection& d : c.unobservable) std::printf("%s\n", in_words(d, names).c_str());
  std::printf("state_bytes %zu (segment %zu, workspace %zu); VIO %.2f ms per frame (p95 %.2f), calibration %.0f ms\n",
              r.memory.state_bytes, r.memory.segment_bytes, r.memory.workspace_bytes, r.timing.vio_ms_median,
              r.timing.vio_ms_p95, r.timing.calibrate_ms);
}

}  // namespace host
