// Evidence: what is linearised at the last fit.
#include <algorithm>
#include <cmath>

#include "diagnose/evidence.h"
#include "diagnose/fit_rows.h"
#include "diagnose/shift.h"

namespace host::diagnosis {

using Eigen::VectorXd;

/// A side that is fitted worse than all together, by more than segments differ, is lost. So is one without a number.
constexpr double kLostSide = 2;

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
  if (now().sides.empty()) return counted(now().core->linearise(serials, terms), {});
  std::vector<Rows> of;
  std::vector<std::uint32_t> rest = serials;
  for (const FitSide& side : now().sides) {
    const auto others = std::stable_partition(rest.begin(), rest.end(), [&side](std::uint32_t serial) {
      return std::count(side.serials.begin(), side.serials.end(), serial) == 0;
    });
    const std::vector<std::uint32_t> own(others, rest.end());
    rest.erase(others, rest.end());
    if (!own.empty()) of.push_back(counted(side.core->linearise(own, terms), side.core->moved()));
  }
  if (!rest.empty()) of.push_back(counted(now().core->linearise(rest, terms), {}));
  std::vector<const Rows*> pointers;
  for (const Rows& rows : of) pointers.push_back(&rows);
  return sum_of(pointers);
}

Rows Evidence::counted(const CoreRows& core, const std::vector<double>& moved) const {
  Rows out{unpacked(core), core.dof};
  count_from_zero(moved, &out);
  out.R = triangle_of(out.R);
  return out;
}

/// Of columns [theta | taken | candidates]: theta from the fit's, `moved` of which they were linearised at (empty: at
/// it), terms from zero.
void Evidence::count_from_zero(const std::vector<double>& moved, Rows* rows) const {
  VectorXd at = VectorXd::Zero(rows->columns());
  at.segment(now().n_theta, static_cast<Eigen::Index>(now().taken.size())) = now().taken_values;
  for (std::size_t i = 0; i < moved.size(); ++i) at(static_cast<Eigen::Index>(i)) += moved[i];
  count_from(at, rows);
}

Problem Evidence::at_step(const Shift& step, const VectorXd& before, const VectorXd& after) {
  std::vector<std::uint32_t> serials[2];
  const std::vector<CoreKept> kept = segments();
  for (std::size_t i = 0; i < kept.size(); ++i) {
    if (static_cast<int>(i) != step.straddling)
      serials[is_after(step, now().problem.pieces[i]) ? 1 : 0].push_back(kept[i].segment.serial);
  }
  now().sides.clear();
  const bool both = !serials[0].empty() && !serials[1].empty();  // another set of effects may keep none on one side
  for (int side = 0; both && side < 2; ++side) {
    std::vector<double> expected(static_cast<std::size_t>(now().n_theta) + now().taken.size());
    VectorXd::Map(expected.data(), now().n_theta) = side == 0 ? before : after;
    now().sides.push_back({serials[side], now().core->side(serials[side], expected)});
    budget_->spend(now().sides.back().core->work());
  }
  const double of_all = now().result.result.chi2 / now().result.result.dof;
  const auto sound = [of_all](const FitSide& side) { return side.core->chi2_per_dof() <= kLostSide * of_all; };
  if (!std::all_of(now().sides.begin(), now().sides.end(), sound)) now().sides.clear();
  now().beside.clear();  // another fit() linearises anew
  gather_columns();
  return now().problem;
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

/// Null where its rows are of the one theta of all.
const FitSide* Evidence::side_with(std::uint32_t serial) const {
  for (const FitSide& side : now().sides) {
    if (std::count(side.serials.begin(), side.serials.end(), serial) > 0) return &side;
  }
  return nullptr;
}

SensorPieces Evidence::sensors() {
  std::vector<CoreTerm> terms;
  for (const TermInfo& t : now().candidates) terms.push_back(t.term);
  SensorPieces out;
  const ExposureColumn& exposure = now().exposure;
  for (const CoreKept& k : segments()) {
    const FitSide* side = side_with(k.segment.serial);
    const CoreSensorRows core =
        side ? side->core->sensor_rows(k.segment.serial, terms) : now().core->sensor_rows(k.segment.serial, terms);
    for (std::size_t s = 0; s < out.of.size(); ++s) {
      Rows rows{core.root[s], core.shared.row(static_cast<int>(s)).sum()};
      count_from_zero(side ? side->core->moved() : std::vector<double>(), &rows);
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
  in_parts = in_parts || !now().sides.empty();
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
  if (!now().sides.empty()) {  // nothing links their segments
    sum_pieces(&out);
    return out;
  }
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
