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

/// What a fit depends on: the terms, which of them are estimated and from where on, and the noise.
std::vector<double> Evidence::question(const std::vector<TermInfo>& terms, const std::vector<bool>& estimated,
                                       const std::vector<double>& start) const {
  std::vector<double> out = {options_.pixel_sigma, options_.track_walk, options_.noise.gyro_noise_density,
                             options_.noise.accel_noise_density};
  for (std::size_t i = 0; i < terms.size(); ++i) {
    const CoreTerm& t = terms[i].term;
    for (int n : {terms[i].bit, t.kind, t.a, t.b, t.c, estimated[i] ? 1 : 0}) out.push_back(n);
    if (estimated[i]) out.push_back(start[i]);
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
  if (remembers(asked)) return now().problem;
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
    if (static_cast<int>(i) == now().exposure.at) continue;
    (estimated[i] ? now().taken : now().candidates).push_back(terms[i]);
    if (!estimated[i]) continue;
    if (terms[i].bit >= 0) {
      replay_options.core.effects |= 1u << terms[i].bit;
    } else {
      replay_options.core.terms.push_back(terms[i].term);
    }
    replay_options.core.term_values.push_back(start[i]);
  }
  inflate_until_taken(replay_options, first && budget_->must_answer() ? kMostInflations - 1 : before);
  int next_taken = 0, next_asked = static_cast<int>(now().taken.size());
  for (std::size_t i = 0; i < terms.size(); ++i) {
    if (static_cast<int>(i) != now().exposure.at) now().place.push_back(estimated[i] ? next_taken++ : next_asked++);
  }
  now().problem = gather(now().candidates, true);
  reorder(now().place, &now().problem);
  if (now().exposure.at >= 0)
    add_exposure_column(mean_exposures(segments(), stamped(now().exposure.kappa)), &now().exposure, &now().problem);
  now().asked = asked;  // now it is whole
  return now().problem;
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

std::vector<CoreKept> Evidence::segments() const {
  std::vector<CoreKept> out = now().result.kept;
  std::sort(out.begin(), out.end(), [](const CoreKept& a, const CoreKept& b) {
    return std::pair(a.segment.session, a.segment.start_ns) < std::pair(b.segment.session, b.segment.start_ns);
  });
  return out;
}

Rows Evidence::rows_of(const std::vector<std::uint32_t>& serials, const std::vector<TermInfo>& candidates) {
  std::vector<CoreTerm> terms;
  for (const TermInfo& t : candidates) terms.push_back(t.term);
  const CoreRows core = now().core->linearise(serials, terms);
  Rows out{unpacked(core), core.dof};
  count_from_zero(&out);
  out.R = triangle_of(out.R);
  return out;
}

/// Of columns [theta | taken | candidates].
void Evidence::count_from_zero(Rows* rows) const {
  VectorXd at = VectorXd::Zero(rows->columns() - now().n_theta);
  at.head(static_cast<Eigen::Index>(now().taken.size())) = now().taken_values;
  count_terms_from_zero(now().n_theta, at, rows);
}

double Evidence::seconds_after_start(std::int64_t t_ns) const {
  return 1e-9 * static_cast<double>(t_ns - sessions_.front().cameras.front().frames.front().t_ns);
}

Rows Evidence::joined(const std::vector<std::size_t>& places) {
  const std::vector<CoreKept> kept = segments();
  std::vector<std::uint32_t> serials;
  for (std::size_t i : places) serials.push_back(kept[i].segment.serial);
  if (serials.empty()) return {};
  Rows out = rows_of(serials, now().candidates);
  reorder(now().place, &out, now().n_theta);
  const ExposureColumn& exposure = now().exposure;
  return exposure.at < 0 ? out : with_exposure(out, now().n_theta, exposure, places);
}

SensorPieces Evidence::sensors() {
  std::vector<CoreTerm> terms;
  for (const TermInfo& t : now().candidates) terms.push_back(t.term);
  SensorPieces out;
  const ExposureColumn& exposure = now().exposure;
  for (const CoreKept& k : segments()) {
    const CoreSensorRows core = now().core->sensor_rows(k.segment.serial, terms);
    for (std::size_t s = 0; s < out.of.size(); ++s) {
      Rows rows{core.root[s], core.shared.row(static_cast<int>(s)).sum()};
      count_from_zero(&rows);
      reorder(now().place, &rows, now().n_theta);
      if (exposure.at >= 0) rows = with_exposure(rows, now().n_theta, exposure, exposure.exposure_s[out.shared.size()]);
      out.of[s].push_back(
          {rows, seconds_after_start(k.segment.start_ns), seconds_after_start(k.segment.end_ns), false});
    }
    out.shared.push_back(core.shared);
  }
  return out;
}

/// Columns [theta | taken | candidates].
Problem Evidence::gather(const std::vector<TermInfo>& candidates, bool in_parts) {
  Problem out;
  const std::vector<CoreParameter>& parameters = now().result.result.parameters;
  out.n_theta = now().n_theta = static_cast<int>(parameters.size() - now().taken.size());
  now().taken_values = VectorXd(static_cast<Eigen::Index>(now().taken.size()));
  for (std::size_t i = 0; i < now().taken.size(); ++i)
    now().taken_values(static_cast<Eigen::Index>(i)) = parameters[now().n_theta + i].value;
  out.prior = prior_of(now().result.result, now().n_theta);
  out.noise = std::pow(options_.pixel_sigma / now().result.model.pixel_sigma, 2);
  std::vector<std::uint32_t> all, half[2];
  const std::vector<CoreKept> kept = segments();
  for (std::size_t i = 0; i < kept.size(); ++i) {
    const CoreSegment& s = kept[i].segment;
    all.push_back(s.serial);
    half[is_held_out(i) ? 1 : 0].push_back(s.serial);
    if (!in_parts) continue;
    out.pieces.push_back({rows_of({s.serial}, candidates), seconds_after_start(s.start_ns),
                          seconds_after_start(s.end_ns), is_held_out(i)});
  }
  if (in_parts) out.blocks = blocks_of(now().result.calibration);
  if (half[1].empty()) return out;
  out.all = rows_of(all, candidates);
  if (!in_parts) return out;
  out.train = rows_of(half[0], candidates);
  out.held_out = rows_of(half[1], candidates);
  return out;
}

Problem Evidence::at_last_fit(const std::vector<TermInfo>& candidates, bool in_parts) {
  return gather(candidates, in_parts);
}

}  // namespace host::diagnosis
