// A recording in small: segments with random Jacobians over [theta | terms], a known truth, unit noise.
#pragma once

#include <Eigen/QR>
#include <algorithm>
#include <functional>
#include <string>
#include <vector>

#include "../support/random.h"
#include "diagnose/selection.h"

namespace test {

struct LinearRecording {
  static constexpr double kShare = 0.9 / 5;  ///< of the error level: five candidates share nine tenths
  int n_theta = 6, segments = 12, rows = 120;
  std::vector<host::diagnosis::Candidate> candidates;
  Eigen::VectorXd truth;  ///< of the terms
  double noise = 1;       ///< sigma of the residuals
  /// Adds what no candidate explains to a segment's residuals; may be empty.
  std::function<void(int segment, const Eigen::MatrixXd& J, Eigen::VectorXd* r)> outside;
  /// theta changes by this from segment `step_at` on; empty: it does not.
  Eigen::VectorXd step;
  int step_at = 0;
  /// Changes the Jacobian of a segment, to make candidates alike; may be empty.
  std::function<void(Eigen::MatrixXd* J)> shape;

  int terms() const { return static_cast<int>(truth.size()); }
  void add(const std::string& name, int count, double size, double value = 0) {
    candidates.push_back({name, {terms(), count}, std::vector<double>(count, size), kShare});
    Eigen::VectorXd longer = Eigen::VectorXd::Zero(terms() + count);
    longer.head(terms()) = truth;
    longer.tail(count).setConstant(value);
    truth = longer;
  }
};

inline host::diagnosis::Problem problem_of(const LinearRecording& recording, Random* random) {
  using namespace host::diagnosis;
  Problem out;
  out.n_theta = recording.n_theta;
  out.prior = {Eigen::VectorXd::Zero(recording.n_theta), Eigen::VectorXd::Constant(recording.n_theta, 1.0)};
  out.blocks = {{"first", {0, 3}, std::vector<double>(3, 1.0)}, {"second", {3, 3}, std::vector<double>(3, 1.0)}};
  std::vector<Rows> segments;
  const int n = recording.n_theta + recording.terms();
  for (int s = 0; s < recording.segments; ++s) {
    Eigen::MatrixXd J = random->matrix(recording.rows, n);
    if (recording.shape) recording.shape(&J);
    Eigen::VectorXd r = recording.noise * random->matrix(recording.rows, 1);
    r += J.rightCols(recording.terms()) * recording.truth;
    if (recording.step.size() > 0 && s >= recording.step_at) r += J.leftCols(recording.n_theta) * recording.step;
    if (recording.outside) recording.outside(s, J, &r);
    Eigen::MatrixXd rows(recording.rows, n + 1);
    rows << J, r;
    segments.push_back({triangle_of(rows), static_cast<double>(recording.rows)});
  }
  std::vector<const Rows*> all, half[2];
  for (int s = 0; s < recording.segments; ++s) {
    out.pieces.push_back({segments[s], 4.0 * s, 4.0 * s + 4, (s + 1) / 2 % 2 == 1});
    all.push_back(&segments[s]);
    half[(s + 1) / 2 % 2].push_back(&segments[s]);
  }
  out.all = sum_of(all);
  out.train = sum_of(half[0]);
  out.held_out = sum_of(half[1]);
  return out;
}

/// Of what was accepted, in the order of letters.
inline std::vector<std::string> names(const host::diagnosis::Selection& s) {
  std::vector<std::string> out;
  for (const host::diagnosis::Accepted& a : s.accepted) out.push_back(s.candidates[a.candidate].name);
  std::sort(out.begin(), out.end());
  return out;
}

}  // namespace test
