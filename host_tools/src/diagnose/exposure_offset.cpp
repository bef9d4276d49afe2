#include "diagnose/exposure_offset.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "diagnose/answer.h"
#include "formatted.h"

namespace host::diagnosis {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int host_only = -1;  // no kind of the core's

/// Columns [.. | k | ..], and under them a row that k alone has; k counted from zero.
Rows inserted(const Rows& rows, int place, const VectorXd& k, double below, double kappa) {
  const Eigen::Index m = rows.R.rows(), n = rows.R.cols();
  MatrixXd wide = MatrixXd::Zero(m + 1, n + 1);
  wide.topLeftCorner(m, place) = rows.R.leftCols(place);
  wide.block(0, place, m, 1) = k;
  wide(m, place) = below;
  wide.block(0, place + 1, m, n - place) = rows.R.rightCols(n - place);
  wide.col(n) += kappa * wide.col(place);
  return {triangle_of(wide), rows.dof};
}

/// By stamp.
using Exposures = std::map<std::int64_t, double>;

double nearest_to(const Exposures& exposures, std::int64_t t_ns) {
  const auto after = exposures.lower_bound(t_ns);
  if (after == exposures.begin()) return after->second;
  const auto before = std::prev(after);
  return after == exposures.end() || t_ns - before->first < after->first - t_ns ? before->second : after->second;
}

int place_of(const SearchedModel& model) {
  for (std::size_t c = 0; c < model.candidates.size(); ++c)
    if (model.candidates[c].kind == Kind::exposure) return static_cast<int>(c);
  return -1;
}

}  // namespace

TermInfo exposure_term() {
  return {{host_only, 0, 0, 0},
          kExposureOffset,
          -1,
          std::string(kExposureOffset) + ".kappa",
          "-",
          hypothesis(kExposureOffset).size};
}

ExposureColumn exposure_column(const std::vector<TermInfo>& terms, const std::vector<bool>& estimated,
                               const std::vector<double>& start) {
  ExposureColumn out;
  for (std::size_t i = 0; i < terms.size(); ++i) {
    if (terms[i].effect == "time_offset") out.of = static_cast<int>(i);
    if (terms[i].effect != kExposureOffset) continue;
    out.at = static_cast<int>(i);
    out.kappa = estimated[i] ? start[i] : 0;
  }
  return out;
}

std::vector<double> mean_exposures(const std::vector<CoreKept>& kept, const std::vector<Recording>& sessions) {
  std::vector<Exposures> known(sessions.size());
  for (std::size_t s = 0; s < sessions.size(); ++s) {
    for (const Frame& frame : sessions[s].cameras.front().frames)
      if (frame.exposure_s > 0) known[s][frame.t_ns] = frame.exposure_s;
  }
  std::vector<double> out;
  for (const CoreKept& k : kept) {
    double sum = 0;
    for (const CoreState& keyframe : k.keyframes) sum += nearest_to(known.at(k.segment.session), keyframe.t_ns);
    out.push_back(sum / static_cast<double>(std::max<std::size_t>(1, k.keyframes.size())));
  }
  return out;
}

Rows with_exposure(const Rows& segment, int n_theta, const ExposureColumn& column, double exposure_s) {
  return inserted(segment, n_theta + column.at, exposure_s * segment.R.col(n_theta + column.of), 0, column.kappa);
}

Rows with_exposure(const Rows& joined, int n_theta, const ExposureColumn& column,
                   const std::vector<std::size_t>& places) {
  if (places.empty() || joined.empty()) return joined;
  const int of = n_theta + column.of;
  double mean = 0;
  for (std::size_t i : places) mean += column.exposure_s[i] / static_cast<double>(places.size());
  VectorXd product = VectorXd::Zero(joined.R.cols());
  double square = mean * mean * joined.R.col(of).squaredNorm();
  for (std::size_t i : places) {
    const MatrixXd& R = column.segments[i].R;
    const double e = column.exposure_s[i];
    product += (e - mean) * (R.transpose() * R.col(of));
    square += (e * e - mean * mean) * R.col(of).squaredNorm();
  }
  const VectorXd k = mean * joined.R.col(of) + inverse_of_triangle(joined.R).transpose() * product;
  return inserted(joined, n_theta + column.at, k, std::sqrt(std::max(0.0, square - k.squaredNorm())), column.kappa);
}

void add_exposure_column(const std::vector<double>& exposure_s, ExposureColumn* column, Problem* problem) {
  column->exposure_s = exposure_s;
  column->segments.clear();
  std::vector<std::size_t> all, half[2];
  for (std::size_t i = 0; i < problem->pieces.size(); ++i) {
    Piece& piece = problem->pieces[i];
    column->segments.push_back(piece.rows);
    piece.rows = with_exposure(piece.rows, problem->n_theta, *column, exposure_s[i]);
    all.push_back(i);
    half[piece.held_out ? 1 : 0].push_back(i);
  }
  problem->all = with_exposure(problem->all, problem->n_theta, *column, all);
  problem->train = with_exposure(problem->train, problem->n_theta, *column, half[0]);
  problem->held_out = with_exposure(problem->held_out, problem->n_theta, *column, half[1]);
}

void add_exposure_offset(SearchedModel* model) {
  for (Candidate& c : model->candidates)
    if (c.kind == Kind::effect) c.share = share_of(Kind::effect, true);
  const TermInfo kappa = exposure_term();
  Candidate candidate{kExposureOffset,
                      {static_cast<int>(model->terms.size()), 1},
                      {kappa.size},
                      share_of(Kind::exposure, true),
                      Kind::exposure};
  for (const Candidate& c : model->candidates)
    if (c.name == "time_offset") candidate.beside = {c.columns};
  model->candidates.push_back(candidate);
  model->terms.push_back(kappa);
  model->start.push_back(0);
}

std::string kappa_in_words(double kappa, double sigma, double stated) {
  const int digits = std::clamp(static_cast<int>(std::ceil(-std::log10(sigma))), 1, 4);
  return formatted("an image's stamp and the middle of its exposure are %.*f +- %.1g of the exposure apart", digits,
                   kappa, sigma) +
         (stated != 0 ? formatted(", of which %.3g was stated: ", stated) : std::string(": ")) + kExposureOffset;
}

void count_kappa_from_recording(double added, Diagnosis* out) {
  for (DiagnosedEffect& e : out->effects) {
    if (e.name != kExposureOffset) continue;
    DiagnosedParameter& p = e.parameters.front();
    p.value += added;
    e.words = kappa_in_words(p.value, p.sigma, added);
  }
  for (ModelTerm& t : out->model)
    if (t.effect == kExposureOffset) t.parameter.value += added;
  conclude(out);
}

Problem fit_about_kappa(SearchedModel* model, const std::vector<int>& accepted, const std::function<Problem()>& fit) {
  Problem out = fit();
  const int kappa = place_of(*model);
  if (std::count(accepted.begin(), accepted.end(), kappa) == 0) return out;
  const Candidate& candidate = model->candidates[kappa];
  std::vector<TermGroup> others;
  for (int c : accepted)
    if (c != kappa) others.push_back(model->candidates[c].columns);
  for (int round = 0; round < decision::kKappaRounds; ++round) {
    const std::vector<double> before = model->start;
    model->begin_at(out, accepted);
    const double moved = model->start[candidate.columns.first] - before[candidate.columns.first];
    if (std::abs(moved) < decision::kKappaSettles * test_effect(out, candidate, others).sigma(0)) {
      model->start = before;
      break;
    }
    out = fit();
  }
  return out;
}

}  // namespace host::diagnosis
