#include "review/linearised.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "diagnose/fit_rows.h"
#include "diagnose/gyro_path.h"

namespace host::review {
namespace {

using diagnosis::unpacked;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

bool begins_rotation(const CoreParameter& p) {
  const std::string& n = p.name;
  return n.size() > 7 && (n.compare(n.size() - 7, 7, ".r_CI.x") == 0 || n.compare(n.size() - 7, 7, ".r_AI.x") == 0);
}

Vector3d three(const std::vector<CoreParameter>& p, std::size_t i, double CoreParameter::*member) {
  return {p[i].*member, p[i + 1].*member, p[i + 2].*member};
}

/// J_l^-1(v): the rotation vector of Exp(d) Exp(v) is v + J_l^-1(v)
/// d to first order (Sola et al., "A micro Lie theory", eq. 146).
Matrix3d left_jacobian_inverse(const Vector3d& v) {
  Matrix3d K;
  K << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  const double t2 = v.squaredNorm(), t = std::sqrt(t2);
  const double e = t2 < 1e-6 ? 1.0 / 12 : (1 - 0.5 * t / std::tan(0.5 * t)) / t2;
  return Matrix3d::Identity() - 0.5 * K + e * (K * K);
}

}  // namespace

MatrixXd printed_by_columns(const std::vector<CoreParameter>& p) {
  const auto n = static_cast<Eigen::Index>(p.size());
  MatrixXd out = MatrixXd::Identity(n, n);
  for (std::size_t i = 0; i < p.size(); ++i) {
    if (begins_rotation(p[i]))
      out.block<3, 3>(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(i)) =
          left_jacobian_inverse(three(p, i, &CoreParameter::value));
  }
  return out;
}

VectorXd step_from_start(const std::vector<CoreParameter>& p) {
  VectorXd out(static_cast<Eigen::Index>(p.size()));
  for (std::size_t i = 0; i < p.size(); ++i) out(static_cast<Eigen::Index>(i)) = p[i].value - p[i].initial;
  for (std::size_t i = 0; i < p.size(); ++i) {
    if (!begins_rotation(p[i])) continue;
    const Eigen::AngleAxisd turn(rotation_of(three(p, i, &CoreParameter::value)) *
                                 rotation_of(three(p, i, &CoreParameter::initial)).transpose());
    out.segment<3>(static_cast<Eigen::Index>(i)) = turn.angle() * turn.axis();
  }
  return out;
}

std::vector<const CoreKept*> in_order(const ReplayResult& result) {
  std::vector<const CoreKept*> out;
  for (const CoreKept& k : result.kept) out.push_back(&k);
  std::sort(out.begin(), out.end(), [](const CoreKept* a, const CoreKept* b) {
    return std::pair(a->segment.session, a->segment.start_ns) < std::pair(b->segment.session, b->segment.start_ns);
  });
  return out;
}

diagnosis::Problem linearised(Core& core, const ReplayResult& result,
                              const std::vector<diagnosis::TermInfo>& candidates) {
  const std::vector<CoreParameter>& parameters = result.result.parameters;
  std::vector<CoreTerm> terms;
  for (const diagnosis::TermInfo& t : candidates) terms.push_back(t.term);
  const auto rows_of = [&core, &terms](const std::vector<std::uint32_t>& serials) {
    const CoreRows rows = core.linearise(serials, terms);
    return diagnosis::Rows{unpacked(rows), rows.dof};
  };
  diagnosis::Problem out;
  out.n_theta = static_cast<int>(parameters.size());
  out.prior.mean = -step_from_start(parameters);
  out.prior.sigma = VectorXd(out.n_theta);
  for (int i = 0; i < out.n_theta; ++i) out.prior.sigma(i) = parameters[static_cast<std::size_t>(i)].prior_sigma;
  const std::vector<const CoreKept*> kept = in_order(result);
  if (kept.size() < 2) return out;
  std::vector<std::uint32_t> all, half[2];
  std::int64_t zero_ns = kept.front()->segment.start_ns;
  for (std::size_t i = 0; i < kept.size(); ++i) {
    const CoreSegment& s = kept[i]->segment;
    if (i > 0 && s.session != kept[i - 1]->segment.session)
      zero_ns += s.start_ns - kept[i - 1]->segment.end_ns;  // as if it went on
    const bool held_out = (i + 1) / 2 % 2 == 1;  // both halves see the whole time: 0, 3, 4, 7, 8, ... against the rest
    all.push_back(s.serial);
    half[held_out ? 1 : 0].push_back(s.serial);
    out.pieces.push_back({rows_of({s.serial}), 1e-9 * static_cast<double>(s.start_ns - zero_ns),
                          1e-9 * static_cast<double>(s.end_ns - zero_ns), held_out});
  }
  out.all = rows_of(all);
  out.train = rows_of(half[0]);
  out.held_out = rows_of(half[1]);
  return out;
}

}  // namespace host::review
