#include "review/one_segment.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "formatted.h"

namespace host::review {
namespace {

/// Of a variance: three quarters of the information are one segment's. Eight segments have up to 1.9 in simulation and
/// with real IMUs, four on euroc_mh01 2.0. Along EuRoC's MH_03, where one segment has all of the take-off's
/// acceleration, 7 to 8, and values 5.4 sigma off that nothing else shows.
constexpr double kRests = 4;

}  // namespace

OneSegment rests_on_one_segment(const diagnosis::Problem& problem, const Eigen::MatrixXd& printed) {
  const int n = problem.n_theta;
  OneSegment out;
  out.variance_factor = Eigen::VectorXd::Ones(n);
  if (problem.pieces.size() < 3) return out;
  const auto only_theta = [n](const diagnosis::Rows& rows) { return diagnosis::with_groups(rows, n, {}); };
  const Eigen::MatrixXd R_all = diagnosis::with_prior(only_theta(problem.all), problem.prior).R.leftCols(n);
  const Eigen::MatrixXd H = R_all.transpose() * R_all;
  const Eigen::ArrayXd of_all = (printed * H.inverse() * printed.transpose()).diagonal();
  for (const diagnosis::Piece& piece : problem.pieces) {
    const Eigen::MatrixXd R = only_theta(piece.rows).R.leftCols(n);
    const Eigen::MatrixXd without = (H - R.transpose() * R).inverse();
    const Eigen::ArrayXd factor = (printed * without * printed.transpose()).diagonal().array() / of_all;
    if (factor.maxCoeff() < std::max(kRests, out.largest * out.largest)) continue;
    out.largest = std::sqrt(factor.maxCoeff());
    out.variance_factor = factor.max(1);
  }
  for (int i = 0; i < n; ++i) {
    if (out.variance_factor(i) >= kRests) out.values.push_back(i);
  }
  return out;
}

std::optional<Note> note_on_one_segment(const OneSegment& one, const std::vector<CoreParameter>& parameters) {
  if (one.values.empty()) return std::nullopt;
  std::string names;
  for (const int i : one.values) names += (names.empty() ? "" : ", ") + parameters[static_cast<std::size_t>(i)].name;
  return Note{"one_segment", one.largest,
              formatted("one segment tells most of what is known of %s, and no other can show whether it is right: the "
                        "sigmas of all values are what the other segments know. Record more of that motion",
                        names.c_str())};
}

}  // namespace host::review
