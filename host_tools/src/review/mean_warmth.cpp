#include "review/mean_warmth.h"

#include "sensors/effect_terms.h"

namespace host::review {
namespace {

using Eigen::VectorXd;

/// A term's column in the rows, and the step of theta that one unit of it is at a warmth of 1.
struct WarmTerm {
  Eigen::Index column;
  VectorXd step;
};

/// Of all cameras: camera_temperature is common to them (lib/src/sensors/warm_camera.h).
VectorXd step_of(int value, const std::vector<CoreParameter>& parameters) {
  const std::vector<std::string> moved[] = {{"r_CI.x"}, {"r_CI.y"}, {"r_CI.z"}, {"fx", "fy"}, {"cx"}, {"cy"}};
  VectorXd out = VectorXd::Zero(static_cast<Eigen::Index>(parameters.size()));
  double f[2] = {1, 1};
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const std::string& name = parameters[i].name;
    if (name.rfind("cam", 0) != 0) continue;
    const std::string last = name.substr(name.find('.') + 1);
    if (last == "fx") f[0] = parameters[i].value;
    if (last == "fy") f[1] = parameters[i].value;
    for (const std::string& m : moved[value]) {
      if (last == m) out(static_cast<Eigen::Index>(i)) = value < 3 ? 1 : f[m[1] == 'y' ? 1 : 0];
    }
  }
  return out;
}

/// Upper triangles stay so: theta stands before the candidates.
void take_off(const std::vector<WarmTerm>& terms, double warmth, diagnosis::Rows* rows) {
  for (const WarmTerm& t : terms) rows->R.col(t.column) -= warmth * (rows->R.leftCols(t.step.size()) * t.step);
}

}  // namespace

void count_from_mean_warmth(const std::vector<CoreParameter>& parameters,
                            const std::vector<diagnosis::TermInfo>& candidates, diagnosis::Problem* problem) {
  std::vector<WarmTerm> terms;
  double along = 0, squares = 0;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    const CoreTerm& t = candidates[i].term;
    if (t.kind != static_cast<int>(SEGCAL_NS::TermKind::camera_warmth)) continue;
    terms.push_back({problem->n_theta + static_cast<Eigen::Index>(i), step_of(t.a, parameters)});
    const VectorXd step = problem->all.R.leftCols(problem->n_theta) * terms.back().step;
    along += step.dot(problem->all.R.col(terms.back().column));
    squares += step.squaredNorm();
  }
  if (!(squares > 0)) return;
  for (diagnosis::Rows* rows : {&problem->all, &problem->train, &problem->held_out})
    take_off(terms, along / squares, rows);
  for (diagnosis::Piece& piece : problem->pieces) take_off(terms, along / squares, &piece.rows);
}

}  // namespace host::review
