#include "diagnose/evidence.h"

#include <algorithm>
#include <cmath>

#include "replay/counters.h"

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
/// Segments dropped of all that tell something; with more the fit is made with larger noise.
constexpr double kDroppedShare = 0.25;

MatrixXd unpacked(const CoreRows& rows) {
  const int n = rows.n_theta + rows.n_candidates + 1;
  MatrixXd R = MatrixXd::Zero(n, n);
  std::size_t at = 0;
  for (int i = 0; i < n; ++i) {
    for (int c = i; c < n; ++c) R(i, c) = rows.triangle[at++];
  }
  return R;
}

/// Steps of these blocks are looked for; sizes of a shock.
std::vector<Block> blocks_of(const Calibration& calibration) {
  std::vector<Block> out;
  int at = 0;
  const auto add = [&out, &at](const std::string& name, int count, double size) {
    out.push_back({name, {at, count}, std::vector<double>(count, size)});
    at += count;
  };
  for (std::size_t c = 0; c < calibration.cameras.size(); ++c) {
    const std::string cam = "cam" + std::to_string(c) + ".";
    add(cam + "r_CI", 3, 0.05);
    add(cam + "p_CI", 3, 0.03);
    add(cam + "f", 2, 10);
    add(cam + "c", 2, 10);
    add(cam + "distortion", calibration.cameras[c].model == DistortionModel::fov ? 1 : 4, 0.03);
  }
  add("gyro.s", 3, 0.02);
  add("gyro.m", 3, 0.02);
  add("accel.s", 3, 0.03);
  add("accel.m", 3, 0.03);
  add("accel.r_AI", 3, 0.03);
  return out;
}

Prior prior_of(const CoreResult& result, int n) {
  Prior out{VectorXd(n), VectorXd(n)};
  for (int i = 0; i < n; ++i) {
    const CoreParameter& p = result.parameters[i];
    out.mean(i) = p.initial - p.value;
    out.sigma(i) = p.prior_sigma;
  }
  return out;
}

/// Terms from their places among [taken | asked] to the caller's order.
void reorder(const std::vector<int>& place, Rows* rows, int n_theta) {
  MatrixXd out = rows->R;
  for (std::size_t i = 0; i < place.size(); ++i)
    out.col(n_theta + static_cast<int>(i)) = rows->R.col(n_theta + place[i]);
  rows->R = triangle_of(out);
}
void reorder(const std::vector<int>& place, Problem* problem) {
  for (Rows* rows : {&problem->all, &problem->train, &problem->held_out}) {
    if (!rows->empty()) reorder(place, rows, problem->n_theta);
  }
  for (Piece& p : problem->pieces) reorder(place, &p.rows, problem->n_theta);
}

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
                   std::function<void(double)> progress)
    : sessions_(sessions), options_(options), profile_(profile), progress_(std::move(progress)) {
  options_.outdated_level = -1;  // a step of the calibration is to be found, not forgotten
  options_.watched_effects = 1;  // segments that do not follow their IMU samples stay: it may be the effect
  options_.segments = profile == "host" ? 64 : options_.segments;
  options_.segment_s = std::max(std::min(options_.segment_s, kShortestSegment),
                                std::min(options_.segment_s, seconds_of(sessions) / kSegments));
}

Problem Evidence::fit(const std::vector<TermInfo>& terms, const std::vector<bool>& estimated,
                      const std::vector<double>& start) {
  ReplayOptions replay_options;
  replay_options.core = options_;
  replay_options.profile = profile_;
  replay_options.progress = progress_;
  replay_options.keep_core = &core_;
  taken_.clear();
  asked_.clear();
  for (std::size_t i = 0; i < terms.size(); ++i) {
    (estimated[i] ? taken_ : asked_).push_back(terms[i]);
    if (!estimated[i]) continue;
    if (terms[i].bit >= 0) {
      replay_options.core.effects |= 1u << terms[i].bit;
    } else {
      replay_options.core.terms.push_back(terms[i].term);
    }
    replay_options.core.term_values.push_back(start[i]);
  }
  const CoreOptions stated = replay_options.core;
  for (inflations_ = std::max(0, inflations_ - 1);; ++inflations_) {  // an effect more: smaller noise may do
    replay_options.core = inflated(stated, inflations_);
    if (try_fit(replay_options) || inflations_ + 1 == kMostInflations) break;
  }
  Problem mixed = gather(asked_, true);
  place_.resize(terms.size());
  int next_taken = 0, next_asked = static_cast<int>(taken_.size());
  for (std::size_t i = 0; i < terms.size(); ++i) place_[i] = estimated[i] ? next_taken++ : next_asked++;
  reorder(place_, &mixed);
  return mixed;
}

/// True if the fit was taken, with nearly all of the segments.
bool Evidence::try_fit(const ReplayOptions& options) {
  result_ = replay(sessions_, options);
  const double dropped = count_of(result_.counters, "segments_unsettled");
  return result_.result.status != "failed" &&
         dropped <= kDroppedShare * (dropped + static_cast<double>(result_.kept.size()));
}

std::vector<CoreKept> Evidence::segments() const {
  std::vector<CoreKept> out = result_.kept;
  std::sort(out.begin(), out.end(), [](const CoreKept& a, const CoreKept& b) {
    return std::pair(a.segment.session, a.segment.start_ns) < std::pair(b.segment.session, b.segment.start_ns);
  });
  return out;
}

Rows Evidence::rows_of(const std::vector<std::uint32_t>& serials, const std::vector<TermInfo>& candidates) {
  std::vector<CoreTerm> terms;
  for (const TermInfo& t : candidates) terms.push_back(t.term);
  const CoreRows core = core_->linearise(serials, terms);
  Rows out{unpacked(core), core.dof};
  count_from_zero(&out);
  out.R = triangle_of(out.R);
  return out;
}

/// Of columns [theta | taken | candidates].
void Evidence::count_from_zero(Rows* rows) const {
  VectorXd at = VectorXd::Zero(rows->columns() - n_theta_);
  at.head(static_cast<Eigen::Index>(taken_.size())) = taken_values_;
  count_terms_from_zero(n_theta_, at, rows);
}

double Evidence::seconds_after_start(std::int64_t t_ns) const {
  return 1e-9 * static_cast<double>(t_ns - sessions_.front().cameras.front().frames.front().t_ns);
}

Rows Evidence::joined(const std::vector<std::size_t>& places) {
  const std::vector<CoreKept> kept = segments();
  std::vector<std::uint32_t> serials;
  for (std::size_t i : places) serials.push_back(kept[i].segment.serial);
  if (serials.empty()) return {};
  Rows out = rows_of(serials, asked_);
  reorder(place_, &out, n_theta_);
  return out;
}

SensorPieces Evidence::sensors() {
  std::vector<CoreTerm> terms;
  for (const TermInfo& t : asked_) terms.push_back(t.term);
  SensorPieces out;
  for (const CoreKept& k : segments()) {
    const CoreSensorRows core = core_->sensor_rows(k.segment.serial, terms);
    for (std::size_t s = 0; s < out.of.size(); ++s) {
      Rows rows{core.root[s], core.shared.row(static_cast<int>(s)).sum()};
      count_from_zero(&rows);
      reorder(place_, &rows, n_theta_);
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
  const std::vector<CoreParameter>& parameters = result_.result.parameters;
  out.n_theta = n_theta_ = static_cast<int>(parameters.size() - taken_.size());
  taken_values_ = VectorXd(static_cast<Eigen::Index>(taken_.size()));
  for (std::size_t i = 0; i < taken_.size(); ++i)
    taken_values_(static_cast<Eigen::Index>(i)) = parameters[n_theta_ + i].value;
  out.prior = prior_of(result_.result, n_theta_);
  out.noise = std::pow(options_.pixel_sigma / result_.model.pixel_sigma, 2);
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
  if (in_parts) out.blocks = blocks_of(result_.calibration);
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
