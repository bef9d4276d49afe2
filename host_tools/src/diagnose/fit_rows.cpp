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
