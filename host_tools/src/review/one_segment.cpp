#include "review/one_segment.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "formatted.h"

namespace host::review {
namespace {

using Eigen::MatrixXd;

/// Of a variance: three quarters of the information are one segment's. Eight segments have up to 1.9 in simulation and
/// with real IMUs, four on euroc_mh01 2.0. Along EuRoC's MH_03, where one segment has all of the take-off's
/// acceleration, 7 to 8, and values 5.4 sigma off that nothing else shows.
constexpr double kRests = 4;

/// Share of what is known in a direction; with less, the prior says so, and a float's digits say nothing.
constexpr double kLeastOfOthers = 1e-5;

}  // namespace

OneSegment rests_on_one_segment(const std::vector<diagnosis::Piece>& pieces, const MatrixXd& printed,
                                const MatrixXd& covariance) {
  const Eigen::Index n = printed.rows();
  OneSegment out;
  out.variance_factor = Eigen::VectorXd::Ones(n);
  if (pieces.size() < 3) return out;
  const MatrixXd of_columns = printed.partialPivLu().solve(printed.partialPivLu().solve(covariance).transpose());
  const Eigen::LLT<MatrixXd> factor_of_all(of_columns);
  if (factor_of_all.info() != Eigen::Success) return out;
  const MatrixXd root = factor_of_all.matrixL();  // root root' = H^-1
  for (const diagnosis::Piece& piece : pieces) {
    const MatrixXd R = diagnosis::with_groups(piece.rows, static_cast<int>(n), {}).R.leftCols(n);
    // (H - H_s)^-1 = root (I - A'A)^-1 root' with A = R_s root.
    const MatrixXd A = R * root;
    const Eigen::SelfAdjointEigenSolver<MatrixXd> share(A.transpose() * A);
    const Eigen::VectorXd of_others = (1 - share.eigenvalues().array()).max(kLeastOfOthers).rsqrt();
    const MatrixXd without = printed * root * share.eigenvectors() * of_others.asDiagonal();
    const Eigen::ArrayXd factor = without.rowwise().squaredNorm().array() / covariance.diagonal().array();
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
  return Note{
      "one_segment", one.largest,
      formatted("one segment tells most of what is known of %s, and no other can show whether it is right, so the "
                "sigmas of all values are what the other segments know: record more of that motion",
                names.c_str())};
}

}  // namespace host::review
