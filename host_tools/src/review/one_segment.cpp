#include "review/one_segment.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "formatted.h"
#include "review/names.h"

namespace host::review {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Of a variance: three quarters of the information are one segment's. Eight segments of a minute have up to 1.9 in
/// simulation and with real IMUs, of three or two in 14 s one often tells nearly all, four on euroc_mh01 2.0. Along
/// EuRoC's MH_03, where one segment has all of the take-off's acceleration, 7 to 8, and values 5.4 sigma off that
/// nothing else shows.
constexpr double kRests = 4;

/// Share of what is known in a direction; with less, a float's digits say nothing.
constexpr double kLeastOfOthers = 1e-5;

/// Rows over theta alone.
diagnosis::Rows of_theta(const diagnosis::Rows& rows, int n) { return diagnosis::with_groups(rows, n, {}); }

}  // namespace

OneSegment rests_on_one_segment(const diagnosis::Problem& problem, const MatrixXd& printed) {
  const int n = problem.n_theta;
  OneSegment out;
  out.variance_factor = VectorXd::Ones(n);
  if (problem.pieces.size() < 2) return out;
  const MatrixXd R = diagnosis::with_prior(of_theta(problem.all, n), problem.prior).R.topLeftCorner(n, n);
  const MatrixXd root = R.triangularView<Eigen::Upper>().solve(MatrixXd::Identity(n, n));  // root root' = H^-1
  const Eigen::ArrayXd of_all = (printed * root).rowwise().squaredNorm();
  for (const diagnosis::Piece& piece : problem.pieces) {
    // (H - H_s)^-1 = root (I - A'A)^-1 root' with A = R_s root.
    const MatrixXd A = of_theta(piece.rows, n).R.leftCols(n) * root;
    const Eigen::SelfAdjointEigenSolver<MatrixXd> share(A.transpose() * A);
    const VectorXd of_others = (1 - share.eigenvalues().array()).max(kLeastOfOthers).rsqrt();
    const MatrixXd without = printed * root * share.eigenvectors() * of_others.asDiagonal();
    const Eigen::ArrayXd factor = without.rowwise().squaredNorm().array() / of_all;
    if (factor.maxCoeff() < kRests) continue;
    out.largest = std::max(out.largest, std::sqrt(factor.maxCoeff()));
    out.variance_factor = out.variance_factor.array().max(factor);
  }
  for (int i = 0; i < n; ++i) {
    if (out.variance_factor(i) >= kRests) out.values.push_back(i);
  }
  return out;
}

std::optional<Note> note_on_one_segment(const OneSegment& one, const std::vector<CoreParameter>& parameters) {
  if (one.values.empty()) return std::nullopt;
  std::vector<std::string> names;
  for (const int i : one.values) names.push_back(parameters[static_cast<std::size_t>(i)].name);
  return Note{"one_segment", one.largest,
              formatted("one segment tells most of what is known of %s, and no other can show whether it is right, so "
                        "the sigmas of all values are what the other segments know: record more of that motion",
                        names_of(names).c_str())};
}

}  // namespace host::review
