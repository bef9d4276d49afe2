#include "diagnose/evidence.h"

#include <algorithm>
#include <cmath>

#include "diagnose/fit_rows.h"
#include "replay/counters.h"
#include "stamps/exposures.h"

namespace host::diagnosis {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// A fit with chi2/dof far above 1 is refused by the core, and segments whose states do not follow their IMU samples
/// are dropped. With larger noise they are taken, and what is missing in the model can be asked for.
constexpr double kInflatePixels = 2, kInflateImu = 4;
constexpr int kMostInflations = 3;
/// Segments of a recording: as long as the core's, but not so long that a short recording
/// has few of them. What is named must hold in each of them (Scatter), with the tail of F
/// at 1 and n - 1 degrees of freedom: for p = 1e-4 an effect of one parameter needs 1.9
/// times the statistic that chi-square would ask for with 15 segments, 50 times with four.
constexpr double kSegments = 15, kShortestSegment = 2;
/// Fits that are kept: a search that drops an effect comes back to the fit before it.
constexpr std::size_t kRemembered = 4;
/// Segments dropped of all that tell something; with more the fit is made with larger noise.
constexpr double kDroppedShare = 0.25;

CoreOptions inflated(CoreOptions core, int times) {
  core.pixel_sigma *= std::pow(kInflatePixels, times);
  core.noise.gyro_noise_density *= std::pow(kInflateImu, times);
  core.noise.accel_noise_density *= std::pow(kInflateImu, times);
  return core;
}

void add_term(const TermInfo& info, std::vector<double>* out) {
  const CoreTerm& t = info.term;
  for (int n : {info.bit, t.kind, t.a, t.b, t.c}) out->push_back(n);
}

double seconds_of(const std::vector<Recording>& sessions) {
  double sum = 0;
  for (const Recording& r : sessions) {
    const auto& frames = r.cameras.front().frames;
    if (!frames.empty()) sum += 1e-9 * static_cast<double>(frames.back().t_ns - frames.front().t_ns);
  }
  return sum;
}

}  // namespace

Evidence::Evidence(const std::vector<Recording>& sessions, const CoreOptions& options, const std::string& profile,
                   Budget* budget, std::function<void(double)> progress)
    : sessions_(sessions), options_(options), profile_(profile), budget_(budget), progress_(std::move(progress)) {
  options_.outdated_level = -1;  // a step of the calibration is to be found, not forgotten
  options_.watched_effects = 1;  // segments that do not follow their IMU samples stay: it may be the effect
  options_.segments = profile == "host" ? 64 : options_.segments;
  options_.segment_s = std::max(std::min(options_.segment_s, kShortestSegment),
                                std::min(options_.segment_s, seconds_of(sessions) / kSegments));
}

/// What a fit depends on: the terms that are estimated, where they start, and the noise.
std::vector<double> Evidence::question(const std::vector<TermInfo>& terms, const std::vector<bool>& estimated,
                                       const std::vector<double>& start) const {
  std::vector<double> out = {options_.pixel_sigma, options_.track_walk, options_.noise.gyro_noise_density,
                             options_.noise.accel_noise_density};
  for (std::size_t i = 0; i < terms.size(); ++i) {
    if (!estimated[i]) continue;
    add_term(terms[i], &out);
    out.push_back(start[i]);
  }
  return out;
}

bool Evidence::remembers(const std::vector<double>& asked) {
  const auto found =
      std::find_if(made_.begin(), made_.end(), [&asked](const auto& fit) { return fit->asked == asked; });
  if (found == made_.end()) return false;
  std::rotate(made_.begin(), found, found + 1);
  return true;
}

Problem Evidence::fit(const std::vector<TermInfo>& terms, const std::vector<bool>& estimated,
                      const std::vector<double>& start) {
  const std::vector<double> asked = question(terms, estimated, start);
  std::vector<double> beside;
  for (const TermInfo& term : terms) add_term(term, &beside);
  for (const std::unique_ptr<MadeFit>& fit : made_) fit->sides.clear();  // some ten MB each
  if (!remembers(asked)) make(terms, estimated, start);
  if (now().asked.empty() || now().beside != beside) linearise(terms, estimated, start);
  now().asked = asked;  // now it is whole
  now().beside = beside;
  return now().problem;
}

void Evidence::make(const std::vector<TermInfo>& terms, const std::vector<bool>& estimated,
                    const std::vector<double>& start) {
  ReplayOptions replay_options;
  replay_options.core = options_;
  replay_options.profile = profile_;
  replay_options.progress = progress_;
  const bool first = made_.empty();
  const int before = first ? 0 : now().inflations;
  if (made_.size() == kRemembered) made_.pop_back();
  made_.push_front(std::make_unique<MadeFit>());
  now().inflations = std::max(0, before - 1);  // an effect more: smaller noise may do
  replay_options.keep_core = &now().core;
  now().exposure = exposure_column(terms, estimated, start);
  for (std::size_t i = 0; i < terms.size(); ++i) {
    if (static_cast<int>(i) == now().exposure.at || !estimated[i]) continue;
    now().taken.push_back(terms[i]);
    if (terms[i].bit >= 0) {
      replay_options.core.effects |= 1u << terms[i].bit;
    } else {
      replay_options.core.terms.push_back(terms[i].term);
    }
    replay_options.core.term_values.push_back(start[i]);
  }
  inflate_until_taken(replay_options, first && budget_->must_answer() ? kMostInflations - 1 : before);
}

/// The rows of the fit, with columns for all terms.
void Evidence::linearise(const std::vector<TermInfo>& terms, const std::vector<bool>& estimated,
                         const std::vector<double>& start) {
  now().asked.clear();
  now().exposure = exposure_column(terms, estimated, start);
  now().candidates.clear();
  now().place.clear();
  int next_taken = 0, next_asked = static_cast<int>(now().taken.size());
  for (std::size_t i = 0; i < terms.size(); ++i) {
    if (static_cast<int>(i) == now().exposure.at) continue;
    if (!estimated[i]) now().candidates.push_back(terms[i]);
    now().place.push_back(estimated[i] ? next_taken++ : next_asked++);
  }
  gather_columns();
}

/// In the caller's order.
void Evidence::gather_columns() {
  now().problem = gather(now().candidates, true);
  reorder(now().place, &now().problem);
  if (now().exposure.at >= 0)
    add_exposure_column(mean_exposures(segments(), stamped(now().exposure.kappa)), &now().exposure, &now().problem);
}

/// To `enough` inflations whatever it costs: one that fails for want of them would say that nothing fits.
void Evidence::inflate_until_taken(ReplayOptions options, int enough) {
  const CoreOptions stated = options.core;
  for (;; ++now().inflations) {
    options.core = inflated(stated, now().inflations);
    if (try_fit(options) || now().inflations + 1 == kMostInflations) return;
    if (now().inflations >= enough && !budget_->allows_fit()) return;
  }
}

/// True if the fit was taken, with nearly all of the segments.
bool Evidence::try_fit(const ReplayOptions& options) {
  now().result = replay(stamped(now().exposure.kappa), options);
  budget_->take(now().core->work());
  const double dropped = count_of(now().result.counters, "segments_unsettled");
  return now().result.result.status != "failed" &&
         dropped <= kDroppedShare * (dropped + static_cast<double>(now().result.kept.size()));
}

const std::vector<Recording>& Evidence::stamped(double kappa) {
  if (kappa == 0) return sessions_;
  if (moved_.empty() || kappa != kappa_) {
    moved_ = sessions_;
    for (Recording& r : moved_) move_by_exposure(kappa, &r);
    kappa_ = kappa;
  }
  return moved_;
}

}  // namespace host::diagnosis
