#include "diagnose/clock.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "diagnose/chi_square.h"
#include "eigenvalues.h"
#include "quantile.h"

namespace host {
namespace {

constexpr double window_s = 10;
constexpr std::size_t least_pairs = 30;
constexpr double least_telling_s = 0.02;
constexpr double outlier = 9;  // pairs that fit ten times worse than the middle one count logarithmically
constexpr int rounds = 5;

using Vector7 = Eigen::Matrix<double, 7, 1>;  // gyroscope bias, rad/s; rotation of the camera, rad; offset, s
using Matrix7 = Eigen::Matrix<double, 7, 7>;

// Wide: a bias of 0.2 rad/s, a camera 0.05 rad askew (the default prior), an offset of 0.1 s.
const Vector7 prior_sigma = (Vector7() << 0.2, 0.2, 0.2, 0.05, 0.05, 0.05, 0.1).finished();
// Steps of the differences: a tenth of a pixel or so in each.
const Vector7 step = (Vector7() << 2e-3, 2e-3, 2e-3, 2e-3, 2e-3, 2e-3, 1e-3).finished();

class Window {
 public:
  Window(std::vector<const FramePair*> pairs, const GyroPath& gyro, const Eigen::Matrix3d& R_CI, double start_offset)
      : pairs_(std::move(pairs)), gyro_(gyro), R_CI_(R_CI), start_offset_(start_offset) {}

  /// Misfits per corner of all pairs.
  std::vector<double> misfits(const Vector7& x) const {
    const Eigen::Matrix3d R_CI = rotation_of(x.segment<3>(3)) * R_CI_;
    std::vector<double> out;
    for (const FramePair* p : pairs_) {
      const Eigen::Matrix3d R_I12 =
          gyro_.rotation(p->t1 + start_offset_ + x[6], p->t2 + start_offset_ + x[6], x.head<3>());
      out.push_back(misfit(*p, R_CI * R_I12 * R_CI.transpose()) / static_cast<double>(p->rays1.size()));
    }
    return out;
  }

  void set_noise(const Vector7& x) { noise_ = std::max(quantile(misfits(x), 0.5), 1e-12); }

  /// Like a sum of squares over sigma squared.
  double cost(const Vector7& x) const {
    double sum = x.cwiseQuotient(prior_sigma).squaredNorm();
    const std::vector<double> all = misfits(x);
    for (std::size_t i = 0; i < all.size(); ++i) {
      const auto corners = static_cast<double>(pairs_[i]->rays1.size());
      sum += corners * outlier * std::log1p(all[i] / noise_ / outlier);
    }
    return sum;
  }

  std::size_t size() const { return pairs_.size(); }

 private:
  std::vector<const FramePair*> pairs_;
  const GyroPath& gyro_;
  Eigen::Matrix3d R_CI_;
  double start_offset_, noise_ = 1;
};

/// Gradient and Hessian of the cost by differences.
void differentiate(const Window& window, const Vector7& x, Vector7* gradient, Matrix7* hessian) {
  const double centre = window.cost(x);
  Vector7 plus, minus;
  for (int i = 0; i < 7; ++i) {
    Vector7 a = x, b = x;
    a[i] += step[i];
    b[i] -= step[i];
    plus[i] = window.cost(a);
    minus[i] = window.cost(b);
    (*gradient)[i] = (plus[i] - minus[i]) / (2 * step[i]);
    (*hessian)(i, i) = (plus[i] - 2 * centre + minus[i]) / (step[i] * step[i]);
  }
  for (int i = 0; i < 7; ++i) {
    for (int j = 0; j < i; ++j) {
      Vector7 a = x;
      a[i] += step[i];
      a[j] += step[j];
      (*hessian)(i, j) = (window.cost(a) - plus[i] - plus[j] + centre) / (step[i] * step[j]);
      (*hessian)(j, i) = (*hessian)(i, j);
    }
  }
}

/// Newton, damped where the cost is not convex or rises. False if it does not settle.
bool minimise(Window& window, Vector7* x, double* offset_sigma) {
  Vector7 gradient;
  Matrix7 hessian;
  for (int round = 0; round < rounds; ++round) {
    window.set_noise(*x);
    differentiate(window, *x, &gradient, &hessian);
    const Matrix7 prior = prior_sigma.cwiseAbs2().cwiseInverse().asDiagonal();
    const double lift = std::max(0.0, -1.1 * eigenvalues_of(hessian)[0]);
    Vector7 move = -(hessian + lift * Matrix7::Identity() + prior).ldlt().solve(gradient);
    const double before = window.cost(*x);
    for (int half = 0; half < 6 && !(window.cost(*x + move) < before); ++half) move *= 0.5;
    if (window.cost(*x + move) < before) *x += move;
    if (std::abs(move[6]) < 1e-5 && round > 0) break;
  }
  differentiate(window, *x, &gradient, &hessian);
  // any size, as elsewhere: 7 x 7 would be compiled anew
  const Eigen::MatrixXd covariance = 2 * Eigen::MatrixXd(hessian).inverse();
  *offset_sigma = std::sqrt(covariance(6, 6));
  return covariance(6, 6) > 0 && eigenvalues_of(hessian)[0] > 0;
}

}  // namespace

std::vector<OffsetInWindow> offsets_over_time(const std::vector<FramePair>& pairs, const GyroPath& gyro,
                                              const Eigen::Matrix3d& R_CI, double start_offset) {
  std::vector<OffsetInWindow> out;
  std::size_t k = 0;
  Vector7 x = Vector7::Zero();
  while (k < pairs.size()) {
    const double begin = pairs[k].t1;
    std::vector<const FramePair*> inside;
    for (; k < pairs.size() && pairs[k].t1 < begin + window_s; ++k)
      if (gyro.covers(pairs[k].t1 + start_offset - 0.1, pairs[k].t2 + start_offset + 0.1)) inside.push_back(&pairs[k]);
    if (inside.size() < least_pairs) continue;
    const double middle = 0.5 * (inside.front()->t1 + inside.back()->t2);
    Window window(std::move(inside), gyro, R_CI, start_offset);
    x[6] = 0;
    double sigma = 0;
    Vector7 found = x;
    if (!minimise(window, &found, &sigma) || !(sigma < least_telling_s) || !(std::abs(found[6]) < 0.1)) continue;
    x = found;
    out.push_back({middle, start_offset + found[6], sigma});
  }
  return out;
}

/// By how much the offsets of windows scatter beyond their sigmas, as a variance, and the degrees of freedom that this
/// knowledge is worth: translation that passes for rotation is another one in each window. By moments of the logarithms
/// over 30 recordings along five real paths (Smyth, "Linear models and empirical Bayes methods", Statistical
/// Applications in Genetics and Molecular Biology 3, 2004, section 6). Six windows alone know their scatter so badly
/// that chance makes seven sigmas of it.
constexpr double usual_scale = 3.5;
constexpr int scale_dof = 12;

ClockDrift drift_of(const std::vector<OffsetInWindow>& offsets) {
  ClockDrift drift;
  if (offsets.size() < 3) return drift;
  double s0 = 0, s1 = 0, s2 = 0, y0 = 0, y1 = 0;
  for (const OffsetInWindow& o : offsets) {
    // Nothing that this method leaves out (parallax of a rolling shutter, lenses) is known better than to 0.2 ms.
    const double w = 1 / (o.sigma * o.sigma + 4e-8);
    s0 += w;
    s1 += w * o.t;
    s2 += w * o.t * o.t;
    y0 += w * o.offset;
    y1 += w * o.t * o.offset;
  }
  const double determinant = s0 * s2 - s1 * s1;
  drift.slope = (s0 * y1 - s1 * y0) / determinant;
  const double at_zero = (s2 * y0 - s1 * y1) / determinant;
  double chi2 = 0;
  for (const OffsetInWindow& o : offsets) {
    const double off = o.offset - at_zero - drift.slope * o.t;
    chi2 += off * off / (o.sigma * o.sigma + 4e-8);
  }
  const int dof = scale_dof + static_cast<int>(offsets.size()) - 2;
  const double scale = std::max(1.0, (scale_dof * usual_scale + chi2) / dof);
  drift.sigma = std::sqrt(scale * s0 / determinant);
  drift.log10_p = diagnosis::log10_upper_tail_of_ratio(drift.slope * drift.slope / (drift.sigma * drift.sigma), 1, dof);
  drift.offset = at_zero + drift.slope * s1 / s0;
  drift.change = drift.slope * (offsets.back().t - offsets.front().t);
  return drift;
}

}  // namespace host
