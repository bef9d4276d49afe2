#include "allan/allan.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "diagnose/rest.h"
#include "formatted.h"
#include "quantile.h"

namespace host {
namespace {

constexpr double two_ln2_over_pi = 0.4412712;
constexpr double walk_sigmas = 2;  // a walk is seen where its square is above zero by this many sigmas

using Columns = std::array<std::vector<double>, 6>;

Columns columns_of(const std::vector<ImuSample>& samples) {
  Columns axes;
  for (const ImuSample& s : samples)
    for (std::size_t i = 0; i < 3; ++i) {
      axes[i].push_back(s.gyro[i]);
      axes[3 + i].push_back(s.accel[i]);
    }
  return axes;
}

/// Range of a column between its 1 % and 99 % quantiles: what moved, not what was noise in one sample.
double spread(const std::vector<double>& column) { return quantile(column, 0.99) - quantile(column, 0.01); }

[[noreturn]] void refuse(const Columns& axes, double rate_hz, const Span& rest) {
  const double all_s = static_cast<double>(axes[0].size()) / rate_hz,
               rest_s = static_cast<double>(rest.end - rest.begin) / rate_hz;
  if (all_s < least_rest_s)
    throw NotAtRest(
        formatted("too short: %.1f s of IMU samples, at least %.0f s at rest are needed, an hour for the bias walks",
                  all_s, least_rest_s));
  double turn = 0, push = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    turn = std::max(turn, spread(axes[i]));
    push = std::max(push, spread(axes[3 + i]));
  }
  throw NotAtRest(
      formatted(
          "not at rest: the longest rest takes %.1f s; rates spread over %.3g rad/s and accelerations over %.3g m/s^2",
          rest_s, turn, push) +
      formatted("; put the device on a table that nobody touches, for %.0f s at least, an hour for the bias walks",
                least_rest_s));
}

/// Overlapping averages do not multiply what a rest tells: T / tau - 1 of them are independent.
double relative_variance(double tau_s, double rest_s) { return 2 / std::max(rest_s / tau_s - 1, 1.0); }

/// Least squares in the squares of the three terms, none of them below zero: the best of the seven subsets.
Eigen::Vector3d squares_fit(const Eigen::MatrixXd& A, const Eigen::VectorXd& y) {
  Eigen::Vector3d best = Eigen::Vector3d::Zero();
  double best_cost = y.squaredNorm();
  for (int subset = 1; subset < 8; ++subset) {
    std::vector<Eigen::Index> used;
    for (int i = 0; i < 3; ++i)
      if (subset >> i & 1) used.push_back(i);
    const Eigen::MatrixXd part = A(Eigen::all, used);
    const Eigen::VectorXd x = part.colPivHouseholderQr().solve(y);
    const double cost = (part * x - y).squaredNorm();
    if ((x.array() < 0).any() || cost >= best_cost) continue;
    best_cost = cost;
    best.setZero();
    for (std::size_t i = 0; i < used.size(); ++i) best[used[i]] = x[static_cast<Eigen::Index>(i)];
  }
  return best;
}

SensorFit fit_sensor(const std::vector<double>* axes, const Span& rest, double rate_hz, double rest_s) {
  SensorFit fit;
  fit.points = allan_deviation(axes, rest, rate_hz);
  for (std::size_t i = 0; i < 3; ++i) fit.axes[i] = fit_axis(fit.points, i, rest_s);
  return fit;
}

template <typename Value>
double largest(const std::array<AxisFit, 3>& axes, Value value) {
  double out = 0;
  for (const AxisFit& axis : axes) out = std::max(out, value(axis));
  return out;
}

}  // namespace

AxisFit fit_axis(const std::vector<AllanPoint>& points, std::size_t axis, double rest_s) {
  const auto n = static_cast<Eigen::Index>(points.size());
  Eigen::MatrixXd terms(n, 3);
  Eigen::VectorXd squares(n), model(n);
  for (Eigen::Index k = 0; k < n; ++k) {
    const AllanPoint& p = points[static_cast<std::size_t>(k)];
    squares[k] = p.deviation[axis] * p.deviation[axis];
    terms.row(k) << 1 / p.tau_s, two_ln2_over_pi, p.tau_s / 3;
  }
  // Weights follow the fitted deviation, not the scattered one; three rounds settle them.
  model = squares.cwiseMax(1e-300);
  Eigen::Vector3d fit = Eigen::Vector3d::Zero();
  Eigen::MatrixXd A(n, 3);
  for (int round = 0; round < 4; ++round) {
    Eigen::VectorXd y(n);
    for (Eigen::Index k = 0; k < n; ++k) {
      const double sigma = model[k] * std::sqrt(relative_variance(points[static_cast<std::size_t>(k)].tau_s, rest_s));
      A.row(k) = terms.row(k) / sigma;
      y[k] = squares[k] / sigma;
    }
    fit = squares_fit(A, y);
    model = (terms * fit).cwiseMax(1e-300);
  }
  AxisFit out;
  out.density = std::sqrt(fit[0]);
  out.instability = std::sqrt(fit[1]);
  const Eigen::Vector3d scale = A.colwise().norm().transpose().cwiseMax(1e-300);
  const Eigen::Matrix3d information =
      scale.cwiseInverse().asDiagonal() * (A.transpose() * A) * scale.cwiseInverse().asDiagonal();
  const double sigma_square = std::sqrt(information.inverse()(2, 2)) / scale[2];  // of walk^2
  out.walk_seen = fit[2] > walk_sigmas * sigma_square;
  out.walk = std::sqrt(out.walk_seen ? fit[2] : fit[2] + walk_sigmas * sigma_square);
  out.walk_sigma = sigma_square / (2 * std::max(out.walk, 1e-300));
  return out;
}

double SensorFit::density() const {
  return largest(axes, [](const AxisFit& a) { return a.density; });
}

bool SensorFit::walk_seen() const {
  return std::any_of(axes.begin(), axes.end(), [](const AxisFit& a) { return a.walk_seen; });
}

double SensorFit::walk() const {
  const bool seen = walk_seen();
  return largest(axes, [seen](const AxisFit& a) { return a.walk_seen || !seen ? a.walk : 0.0; });
}

AllanResult allan_of(const std::vector<ImuSample>& samples) {
  AllanResult result;
  result.rate_hz = median_rate_hz(samples);
  if (!(result.rate_hz > 0)) throw NotAtRest("expected IMU samples with rising stamps");
  const Columns axes = columns_of(samples);
  const Span rest = longest_rest(axes, result.rate_hz);
  const auto n = static_cast<double>(rest.end - rest.begin);
  result.rest_s = n / result.rate_hz;
  if (result.rest_s < least_rest_s) refuse(axes, result.rate_hz, rest);
  result.start_s = static_cast<double>(samples[rest.begin].t_ns - samples.front().t_ns) * 1e-9;
  const double by_stamps_s = static_cast<double>(samples[rest.end - 1].t_ns - samples[rest.begin].t_ns) * 1e-9;
  if (std::abs(by_stamps_s - result.rest_s) > 0.01 * result.rest_s)
    throw NotAtRest(
        formatted("samples are missing: the rest holds %.1f s of samples at %.1f Hz within %.1f s of stamps",
                  result.rest_s, result.rate_hz, by_stamps_s));
  result.gyro = fit_sensor(&axes[0], rest, result.rate_hz, result.rest_s);
  result.accel = fit_sensor(&axes[3], rest, result.rate_hz, result.rest_s);
  if (!(result.gyro.density() > 0 && result.accel.density() > 0))
    throw NotAtRest("no noise in the samples: they do not change, or do not come from a sensor");
  return result;
}

}  // namespace host
