#include "diagnose/fit_rows.h"

namespace host::diagnosis {

using Eigen::MatrixXd;
using Eigen::VectorXd;

MatrixXd unpacked(const CoreRows& rows) {
  const int n = rows.n_theta + rows.n_candidates + 1;
  MatrixXd R = MatrixXd::Zero(n, n);
  std::size_t at = 0;
  for (int i = 0; i < n; ++i) {
    for (int c = i; c < n; ++c) R(i, c) = rows.triangle[at++];
  }
  return R;
}

std::vector<Block> blocks_of(const Calibration& calibration) {
  std::vector<Block> out;
  int at = 0;
  const auto add = [&out, &at](const std::string& of, const StepSize& s, int count) {
    out.push_back({of + s.block, {at, count}, std::vector<double>(count, s.size)});
    at += count;
  };
  for (std::size_t c = 0; c < calibration.cameras.size(); ++c) {
    const int lens = calibration.cameras[c].model == DistortionModel::fov ? 1 : 4;
    for (const StepSize& s : camera_step_sizes()) add("cam" + std::to_string(c) + ".", s, s.count > 0 ? s.count : lens);
  }
  for (const StepSize& s : imu_step_sizes()) add("", s, s.count);
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

}  // namespace host::diagnosis
