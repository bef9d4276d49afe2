#include "diagnose/clock_offset.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "clock/clock_search.h"
#include "clock/line_delay_search.h"
#include "diagnose/answer.h"
#include "diagnose/chi_square.h"
#include "diagnose/decision.h"
#include "diagnose/model_terms.h"
#include "formatted.h"
#include "replay/never_started.h"
#include "replay/replay_clocks.h"

namespace host::diagnosis {
namespace {

constexpr const char* effect_name = "time_offset";

/// By the IMU's clock, up to what is left to estimate.
struct AlignedSessions {
  std::vector<Recording> sessions;
  double offset_s = 0;        ///< of the first session that has one, t_imu - t_cam; added to its camera stamps
  double search_sigma_s = 0;  ///< as parts of the recording scatter
  bool searched = false;      ///< rotation says so; else it was stated
  ClockSearch clock;          ///< of the first session
  LineDelaySearch shutter;    ///< with the stamps moved

  double sigma_s() const { return std::hypot(search_sigma_s, clock_systematic_s); }
  /// Parts that are further apart than rotation is wrong by anyway do not tell of one offset: a gyroscope that lags
  /// behind quick turns only (hysteresis) looks like that. A fit that leaves nothing open speaks for it all the same.
  bool tells_one() const { return search_sigma_s < clock_systematic_s; }
};

double stated(const CoreOptions& options) { return options.calibration.cameras.front().timeshift_cam_imu; }

/// Named by rotation alone: with the stamps moved nothing of it was left.
DiagnosedEffect effect_of(const AlignedSessions& aligned, const TermInfo& term) {
  DiagnosedEffect out;
  out.name = effect_name;
  out.parameters.push_back({term.name, 0, aligned.sigma_s(), term.unit});
  out.statistic = std::pow(aligned.offset_s / aligned.sigma_s(), 2);
  out.dof = 1;
  out.log10_p = log10_upper_tail(out.statistic, out.dof);
  out.gap_closed = std::numeric_limits<double>::quiet_NaN();
  return out;
}

void name_offset(const AlignedSessions& aligned, Diagnosis* out) {
  const auto is_offset = [](const DiagnosedEffect& e) { return e.name == effect_name; };
  if (!aligned.searched || std::any_of(out->effects.begin(), out->effects.end(), is_offset)) return;
  const bool open = out->open_excess > (1 - decision::kNamesFrom) * out->before.total;
  if (open && !aligned.tells_one()) {
    out->rejected.push_back(
        {effect_name,
         formatted("rotation alone shows %.0f ms, and %.0f ms more or less in other parts of the recording",
                   1e3 * aligned.offset_s, 1e3 * aligned.search_sigma_s)});
    return;
  }
  for (const TermInfo& t : core_catalogue(false).terms) {
    if (t.effect != effect_name) continue;
    out->effects.insert(out->effects.begin(), effect_of(aligned, t));
    out->model.insert(out->model.begin(), {t.effect, t.bit, t.term, out->effects.front().parameters.front()});
  }
}

AlignedSessions by_stated_offset(const std::vector<Recording>& sessions, const CoreOptions& options) {
  AlignedSessions out{sessions, stated(options), 0, false, {}, {}};
  for (Recording& session : out.sessions) shift_frames(stated(options), &session);
  return out;
}

/// Not searched: rotation shows no other offset than the stated one.
AlignedSessions by_rotation(const std::vector<Recording>& sessions, const CoreOptions& options) {
  AlignedSessions out{sessions, stated(options), 0, false, {}, {}};
  for (Recording& session : out.sessions) {
    const ClockSearch found = search_clock(session, options.calibration.cameras.front(), stated(options));
    if (&session == &out.sessions.front()) out.clock = found;
    const bool differs = found.differs_from(stated(options));
    shift_frames(differs ? found.offset_s : stated(options), &session);
    if (!differs || out.searched) continue;
    out.searched = true;
    out.offset_s = found.offset_s;
    out.search_sigma_s = found.sigma_s;
  }
  out.shutter = search_line_delay(out.sessions, options.calibration.cameras.front());
  return out;
}

void count_from_recording(const AlignedSessions& aligned, Diagnosis* out) {
  if (!out->judged || !out->lost.empty()) return;
  name_offset(aligned, out);
  for (DiagnosedEffect& e : out->effects) {
    if (e.name != effect_name) continue;
    DiagnosedParameter& p = e.parameters.front();
    p.value += aligned.offset_s;
    e.words = "camera and gyroscope disagree by " + in_words(p.value, p.sigma, p.unit) +
              formatted(aligned.searched ? ", of which rotation told %.1f ms before anything could be fitted: "
                                         : ", of which %.1f ms were stated: ",
                        1e3 * aligned.offset_s) +
              effect_name;
  }
  for (ModelTerm& t : out->model)
    if (t.effect == effect_name) t.parameter.value += aligned.offset_s;
  count_offset_from_recording(aligned.offset_s, &out->fit_before);
  count_offset_from_recording(aligned.offset_s, &out->fit_after);
  conclude(out);
}

/// Too still to judge, and no model that is wrong.
void explain_no_start(const AlignedSessions& moved, Diagnosis* out) {
  if (out->lost.empty()) return;
  const std::string words =
      never_started(out->fit_before.counters, moved.clock, moved.offset_s, moved.sessions.front().imu);
  if (words.empty()) return;
  out->lost.clear();
  out->judged = false;
  out->sentence = "too still to judge: " + words;
  conclude(out);
}

Told told_by(const AlignedSessions& moved) {
  Told told;
  if (moved.searched) told.effects.emplace_back(effect_name);
  if (moved.shutter.shows_rolling_shutter()) {
    told.effects.emplace_back("rolling_shutter");
    told.line_delay = moved.shutter.line_delay;
  }
  return told;
}

/// Nothing has a name: a fit without an offset of tens of milliseconds may not settle, and others look like it there.
bool stuck(const Diagnosis& d) { return d.lost.empty() && d.judged && d.verdict == "unexplained"; }
/// Too little was left to judge: the odometry may have limped along beside it.
bool fitted_little(const Diagnosis& d) { return d.lost.empty() && !d.judged && d.faults.empty(); }

}  // namespace

Diagnosis with_clocks_aligned(const std::vector<Recording>& sessions, const CoreOptions& options,
                              const RunAligned& run) {
  AlignedSessions aligned = by_stated_offset(sessions, options);
  Budget first(decision::kSlices);
  Diagnosis out = run(aligned.sessions, {}, first);
  if (!out.lost.empty() || stuck(out) || fitted_little(out)) {
    AlignedSessions moved = by_rotation(sessions, options);
    const Told told = told_by(moved);
    const bool must_answer = !stuck(out);
    Budget budget(must_answer ? decision::kSlices : std::max<std::int64_t>(decision::kSlicesAgain, first.left()),
                  must_answer);
    Diagnosis again = told.effects.empty() ? out : run(moved.sessions, told, budget);
    const bool better = stuck(out) ? again.verdict == "explained" : !fitted_little(out) || again.judged;
    if (better) {
      out = std::move(again);
      explain_no_start(moved, &out);
      if (moved.searched) aligned = std::move(moved);
    }
  }
  if (aligned.offset_s != 0) count_from_recording(aligned, &out);
  return out;
}

}  // namespace host::diagnosis
