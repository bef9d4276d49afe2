#include "review/review.h"

#include <algorithm>
#include <cmath>

#include "clock/line_delay_search.h"
#include "diagnose/chi_square.h"
#include "diagnose/fault.h"
#include "formatted.h"
#include "replay/counters.h"
#include "replay/never_started.h"
#include "replay/words.h"
#include "review/bias_steps.h"
#include "review/calibration_step.h"
#include "review/followed.h"
#include "review/linearised.h"
#include "review/missing_effects.h"
#include "review/one_segment.h"
#include "review/stated.h"
#include "review/suspected_moves.h"
#include "review/take_back.h"
#include "review/widened_sigmas.h"

namespace host::review {
namespace {

constexpr double kImplausible = -6;  // log10 p of the step from the start

/// chi2/dof beyond which residuals are not the stated noise made larger (a factor of two), but something else: drones,
/// phones and effects of the catalogue's sizes stay below 3. The core goes on to 6, since a fit that failed shows no
/// residuals, and it is they that tell what was stated wrong.
constexpr double kMostRatio = 4;
/// Of what the segments say, over what noise leaves: segments that are five times as
/// far apart do not tell of one calibration. Real recordings have 2 to 13 with the
/// noise of use and 11 to 20 with a tenth of it, a camera that turned late 32 to 62.
constexpr double kMostScatter = 25;

/// The effect that refuses a calibration; null: none does.
const Suspect* refusing(const std::vector<Suspect>& missing) {
  const Suspect* const most = most_moving(missing);
  return most && most->bias_sigmas > kMostBias ? most : nullptr;
}

class Review {
 public:
  Review(const std::vector<Recording>& sessions, const CoreOptions& options, Core& core, ReplayResult* result)
      : sessions_(sessions), options_(options), core_(core), out_(*result), health_(result->health) {}

  void run() {
    health_.frames = count_of(out_.counters, "frames");
    health_.frames_used = count_of(out_.counters, "frames_used");
    health_.filter_restarts = count_of(out_.counters, "filter_restarts");
    find_faults_of_data();
    const bool fitted =
        out_.calibrated && out_.result.dof > 0 && out_.kept.size() >= 2 && out_.result.status != "failed";
    if (fitted) judge_fit();
    find_other_notes();
    if (out_.result.status == "calibrated" && out_.kept.size() == 1 && out_.result.epochs.empty())
      refuse("insufficient", kOneSegment);
    const bool open = !out_.result.changes.empty() && out_.result.changes.back().open;
    if (out_.result.status == "calibrated" && open) refuse("insufficient", open_change_words(out_.result));
    if (out_.result.status != "calibrated" && out_.cause.empty()) out_.cause = reason();
    health_.suspects.insert(health_.suspects.end(), remarks_.begin(), remarks_.end());
  }

 private:
  void find_faults_of_data() {
    for (const Recording& r : sessions_) {
      for (const Fault& f : find_faults(r, options_.calibration)) {
        const Suspect suspect{
            f.kind + "." + f.sensor, f.limit != 0 ? std::abs(f.value / f.limit) : 0, 0, 0, "", f.words, 0, {}};
        (f.is_remark() ? remarks_ : health_.suspects).push_back(suspect);
      }
    }
    faults_ = health_.suspects.size();
  }

  void find_other_notes() {
    for (const Note& note : notes_on_noise(sessions_.front(), out_)) health_.notes.push_back(note);
    for (const Note& note : notes_on_gravity(options_, out_)) health_.notes.push_back(note);
  }

  void judge_fit() {
    const std::vector<Suspect> missing =
        missing_effects(core_, out_, sessions_, options_.has_temperature, &health_.unseen);
    health_.suspects.insert(health_.suspects.end(), missing.begin(), missing.end());
    health_.notes = widen_sigmas(core_, &out_);
    if (out_.result.status != "calibrated") return;
    if (!odometry_stayed(health_)) return refuse("insufficient", used_words(health_));
    if (const std::string step = stepping_bias(missing); !step.empty()) return refuse("failed", step);
    if (out_.result.chi2 > kMostRatio * out_.result.dof) return refuse("failed", "");
    const std::string step = implausible_step();
    if (!step.empty()) return refuse("failed", step);
    if (const Suspect* const effect = refusing(missing)) return refuse("failed", effect->words);
    if (!segments_followed(out_.segments)) return refuse("insufficient", followed_words(out_.segments));
    if (const std::string step = stepping_calibration(missing); !step.empty())
      return refuse("insufficient", after_course(step));
    if (health_.segment_scatter > kMostScatter) return refuse("insufficient", scatter_words(health_));
    for (Suspect& suspect : health_.suspects) widen_by(suspect, &out_);
    refuse_unobserved(&out_);
  }

  /// What changes with time or temperature over sessions looks like a step between two of them.
  std::string after_course(const std::string& words) const {
    const std::string course = out_.result.course.rate_of == "steps" ? "" : course_words(out_.result);
    return course.empty() ? words : course + "; as a step: " + words;
  }

  /// An effect that explains more is named first (a bias that follows temperature steps too), and is the cause where it
  /// takes the answer back itself.
  std::string stepping_bias(const std::vector<Suspect>& missing) {
    const std::optional<Suspect> step = bias_step(sessions_, out_);
    if (!step) return "";
    const bool second = explains_more(missing, *step);
    const std::size_t place = second ? faults_ + missing.size() : faults_;
    health_.suspects.insert(health_.suspects.begin() + static_cast<std::ptrdiff_t>(place), *step);
    const bool effect_refuses = second && refusing(missing);
    return !effect_refuses && step->bias_sigmas > kMostStepBias ? step->words : "";
  }

  /// Not asked where an effect explains more: a lens that is not of its model, a warm sensor look like steps.
  std::string stepping_calibration(const std::vector<Suspect>& missing) {
    const std::optional<Suspect> step = calibration_step(sessions_, core_, out_);
    if (!step || explains_more(missing, *step)) return "";
    health_.suspects.insert(health_.suspects.begin() + static_cast<std::ptrdiff_t>(faults_), *step);
    return step->bias_sigmas > kMostStepBias ? step->words : "";
  }

  /// The prior says where the truth may be; a step far beyond it was not made by noise.
  std::string implausible_step() {
    const std::vector<CoreParameter>& p = out_.result.parameters;
    const Eigen::VectorXd step = step_from_start(p);
    double sum = 0, largest = 0;
    std::size_t which = 0;
    int n = 0;
    for (std::size_t i = 0; i < p.size(); ++i) {
      if (p[i].verdict == "fixed") continue;
      const double sigmas = std::abs(step(static_cast<Eigen::Index>(i))) / p[i].prior_sigma;
      sum += sigmas * sigmas;
      ++n;
      if (sigmas <= largest) continue;
      largest = sigmas;
      which = i;
    }
    health_.step_chi2 = sum;
    health_.step_dof = n;
    if (diagnosis::log10_upper_tail(sum, n) > kImplausible) return "";
    return formatted(
        "the result is too far from the start to be believed: %s from %.5g to %.5g is %.1f of the start's sigmas "
        "(chi2 %.0f of %d); start nearer, or state a clock or lens error first (segcal diagnose)",
        p[which].name.c_str(), p[which].initial, p[which].value, largest, sum, n);
  }

  void refuse(const char* status, const std::string& why) { take_back(status, why, &out_); }

  /// Why there is no calibration, the most certain reason first.
  std::string reason() const {
    const CoreResult& r = out_.result;
    const ClockSearch clock = clocks();
    std::string what;
    if (r.status == "failed") {
      what = r.dof > 0 && r.converged ? formatted("the fit leaves %.1f times the stated noise (chi2/dof %.2f)",
                                                  std::sqrt(r.chi2 / r.dof), r.chi2 / r.dof)
                                      : "the fit did not settle";
    } else if (!odometry_stayed(health_)) {
      what = used_words(health_);
    } else if (!segments_followed(out_.segments)) {
      what = followed_words(out_.segments);
    } else if (out_.kept.empty()) {
      what = !core_.outdated().empty()
                 ? formatted(
                       "the calibration changed: %zu kept segments contradict later ones, which had been condensed "
                       "at the old one; the next session shows the new one",
                       core_.outdated().size())
                 : formatted("no segment told enough to be kept: %zu scored", out_.segments.size());
    } else if (health_.segment_scatter > kMostScatter) {
      what = scatter_words(health_);
    } else {
      const auto observed = std::count_if(r.parameters.begin(), r.parameters.end(),
                                          [](const CoreParameter& p) { return p.verdict == "observed"; });
      what = formatted("the motion tells %d of %zu parameters, half are needed: move and turn about all axes%s",
                       static_cast<int>(observed), r.parameters.size(), room().c_str());
    }
    const std::string shutter = rolling_shutter(clock);
    if (faults_ > 0) return what + ": " + health_.suspects.front().words + (shutter.empty() ? "" : "; " + shutter);
    if (!shutter.empty()) return what + ": " + shutter;
    const double moved_s = out_.clocks.empty() ? 0 : clock.offset_s;
    const std::string still = never_started(out_.counters, clock, moved_s, sessions_.front().imu);
    if (!still.empty()) return what + ": " + still;
    const std::string trouble = odometry_stayed(health_) ? "" : core_.trouble();
    // Clocks that could not be compared are no cause where another one is known.
    const bool compared = clock.correlation != 0;
    if (!clock.words.empty() && (compared || trouble.empty())) return what + ": " + clock.words;
    const bool fitted = odometry_stayed(health_) && (r.status != "failed" || (r.dof > 0 && r.converged));
    const std::string alike = fitted ? "" : turns_alike(clock, moved_s);
    if (!trouble.empty()) return what + ": " + trouble + (alike.empty() ? "" : "; " + alike);
    const bool suspected = !health_.suspects.empty();
    if (suspected && health_.suspects.front().certain) return what + ": " + health_.suspects.front().words;
    for (const Note& note : health_.notes)
      if (note.name.find("_noise") != std::string::npos && note.factor > 1) return what + ": " + note.words;
    if (suspected) return what + ": " + health_.suspects.front().words;
    return alike.empty() ? what : what + ": " + alike;
  }

  /// Empty where it is in the model, or rotation does not show one: a filter that does not know of it does not start.
  std::string rolling_shutter(const ClockSearch& clock) const {
    if (clock.judged && !clock.words.empty()) return "";  // clocks that are apart look like one, and are the cause
    if (sessions_.front().device || (options_.effects & SEGCAL_EFFECT_ROLLING_SHUTTER) != 0) return "";
    const LineDelaySearch found = search_line_delay(sessions_, options_.calibration.cameras.front());
    return found.shows_rolling_shutter() ? found.words + ": --enable rolling_shutter" : "";
  }

  /// A database that was full left out segments that tell something too: a host has room for them. Not a device's log,
  /// which is replayed as it was.
  std::string room() const {
    const auto placed =
        std::count_if(out_.segments.begin(), out_.segments.end(), [](const auto& s) { return s.kept || s.outdated; });
    const int scored = static_cast<int>(out_.segments.size()), room = std::min(scored, most_segments("host"));
    if (sessions_.front().device || placed < options_.segments || room <= options_.segments) return "";
    return formatted("; or keep more of the %d segments: --profile host --segments %d", scored, room);
  }

  /// What the images and the gyroscope say of the clocks; without
  /// words where that is not why odometry or fit went wrong.
  ClockSearch clocks() const {
    const bool moved = !out_.clocks.empty();  // the stamps, to what was found
    ClockSearch found =
        moved ? out_.clocks.front() : search_clock(sessions_.front(), options_.calibration.cameras.front(), 0);
    if (found.judged && (moved || !found.differs_from(0))) found.words.clear();
    return found;
  }

  const std::vector<Recording>& sessions_;
  const CoreOptions& options_;
  Core& core_;
  ReplayResult& out_;
  Health& health_;
  std::size_t faults_ = 0;
  std::vector<Suspect> remarks_;  ///< said, and the cause of nothing
};

}  // namespace

void review(const std::vector<Recording>& sessions, const CoreOptions& options, Core& core, ReplayResult* result) {
  Review(sessions, options, core, result).run();
}

}  // namespace host::review
