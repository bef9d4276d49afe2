#include "reference/imu_residual.h"

#include <Eigen/Cholesky>
#include <algorithm>

#include "reference/link_covariance.h"

namespace host::reference {
namespace {

/// Stamps within a segment are kept in whole microseconds from its first one, so that a sample and an image of the same
/// moment, in two segments, may be apart by the rest of both.
constexpr std::int64_t kRounded_ns = 2000;

using Jet21 = ceres::Jet<double, kIntegralInputs>;

double seconds(std::int64_t from_ns, std::int64_t to_ns) { return static_cast<double>(to_ns - from_ns) * 1e-9; }

/// The polynomial through samples first..last at a time, by Lagrange's formula.
void interpolate(const std::vector<ImuSample>& samples, std::size_t first, std::size_t last, double t_s,
                 std::int64_t zero_ns, Eigen::Vector3d* gyro, Eigen::Vector3d* accel) {
  gyro->setZero();
  accel->setZero();
  for (std::size_t i = first; i <= last; ++i) {
    const double ti = seconds(zero_ns, samples[i].t_ns);
    double weight = 1;
    for (std::size_t k = first; k <= last; ++k) {
      const double tk = seconds(zero_ns, samples[k].t_ns);
      if (k != i) weight *= (t_s - tk) / (ti - tk);
    }
    *gyro += weight * Eigen::Vector3d(samples[i].gyro[0], samples[i].gyro[1], samples[i].gyro[2]);
    *accel += weight * Eigen::Vector3d(samples[i].accel[0], samples[i].accel[1], samples[i].accel[2]);
  }
}

}  // namespace

std::vector<Step> steps_between(const std::vector<ImuSample>& samples, std::int64_t t0_ns, std::int64_t t1_ns) {
  const std::size_t n = samples.size();
  if (n < 2 || samples.front().t_ns > t0_ns + kRounded_ns || samples.back().t_ns < t1_ns - kRounded_ns)
    throw InputError("IMU samples do not reach over a link");
  std::vector<Step> out;
  const auto next = std::upper_bound(samples.begin(), samples.end(), t0_ns,
                                     [](std::int64_t t, const ImuSample& s) { return t < s.t_ns; });
  std::int64_t t = t0_ns;
  for (auto i = static_cast<std::size_t>(next - samples.begin()); t < t1_ns; ++i) {
    const std::int64_t end = i < n ? std::min(t1_ns, samples[i].t_ns) : t1_ns;
    const std::size_t first = i >= 2 ? i - 2 : 0, last = std::min(i + 1, n - 1);
    Step step;
    step.h = seconds(t, end);
    for (int k = 0; k < 3; ++k) {
      interpolate(samples, first, last, seconds(t0_ns, t) + 0.5 * k * step.h, t0_ns, &step.gyro[k], &step.accel[k]);
    }
    out.push_back(step);
    t = end;
  }
  return out;
}

void imu_block(const ImuCalibration& imu, double* out) {
  const auto put = [&out](const Eigen::Matrix3d& T) {
    for (int i = 0; i < 3; ++i) out[i] = T(i, i);
    out[3] = T(0, 1);
    out[4] = T(0, 2);
    out[5] = T(1, 2);
    out += 6;
  };
  put(imu.T_g);
  put(imu.T_a);
  for (int i = 0; i < 3; ++i) out[i] = 0;
}

LinkResidual::LinkResidual(const Problem& problem, const Link& link)
    : from_(problem.states[static_cast<std::size_t>(link.from)]),
      to_(problem.states[static_cast<std::size_t>(link.to)]),
      R_AI0_(problem.theta.imu.R_AI),
      dt_(seconds(from_.t_ns, to_.t_ns)),
      gravity_(problem.model.gravity),
      steps_(steps_between(problem.samples[static_cast<std::size_t>(link.samples)], from_.t_ns, to_.t_ns)) {
  double inputs[kIntegralInputs];
  Eigen::Map<Eigen::Vector3d>{inputs} = from_.b_a;
  Eigen::Map<Eigen::Vector3d>{inputs + 3} = from_.b_g;
  imu_block(problem.theta.imu, inputs + 6);
  weigh(problem.model,
        link_noise(problem.model, problem.samples[static_cast<std::size_t>(link.samples)], from_.t_ns, to_.t_ns),
        inputs);
}

void LinkResidual::weigh(const CoreModel& model, const LinkNoise& white, const double* inputs) {
  const Sensor<double> sensor(inputs, R_AI0_);
  const ErrorModel errors(model, white, inputs, R_AI0_);
  const Eigen::LLT<LinkMatrix> llt(covariance(steps_, sensor, errors));
  weight_ = llt.matrixL().solve(LinkMatrix::Identity());
  for (int k = 0; k < 6; ++k) {
    scale_[k] = inputs[scale_input(k)];
    by_scale_[k] = llt.solve(covariance(steps_, sensor, errors.of_axis(k))).transpose() / scale_[k];
  }
}

/// What the weights' way with the scales does to a residual.
LinkMatrix LinkResidual::by_scales(const double* inputs) const {
  LinkMatrix out = LinkMatrix::Identity();
  for (int k = 0; k < 6; ++k) out += (inputs[scale_input(k)] - scale_[k]) * by_scale_[k];
  return out;
}

template <class T>
void LinkResidual::residual(const Integral<T>& integral, const T* pose0, const T* motion0, const T* pose1,
                            const T* motion1, T* out) const {
  using Map = Eigen::Map<const Vector3<T>>;
  const Eigen::Quaternion<T> q0 = from_.q_GI.cast<T>() * turned_by(pose0), q1 = to_.q_GI.cast<T>() * turned_by(pose1);
  const Vector3<T> g(T(0), T(0), T(-gravity_));
  const T dt(dt_);
  Eigen::Map<Eigen::Matrix<T, kLinkRows, 1>> r(out);
  r.template segment<3>(0) = rotation_vector<T>(integral.q.conjugate() * (q0.conjugate() * q1));
  r.template segment<3>(3) = q0.conjugate() * (Map(motion1) - Map(motion0) - g * dt) - integral.v;
  r.template segment<3>(6) =
      q0.conjugate() * (Map(pose1 + 3) - Map(pose0 + 3) - Map(motion0) * dt - g * (dt * dt / T(2))) - integral.p;
  for (int i = 0; i < 6; ++i) r(9 + i) = motion1[3 + i] - motion0[3 + i];
}

/// The integral by its 21 inputs, and these put where the link's 45 unknowns have them.
Integral<Jet45> LinkResidual::integral_by_unknowns(const double* inputs) const {
  Jet21 jet_inputs[kIntegralInputs];
  for (int i = 0; i < kIntegralInputs; ++i) jet_inputs[i] = Jet21(inputs[i], i);
  const Sensor<Jet21> sensor(jet_inputs, R_AI0_);
  Integral<Jet21> x;
  for (const Step& step : steps_) integrate(step, sensor, &x);
  const auto widened = [](const Jet21& a) {
    Jet45 out(a.a);
    out.v.template segment<6>(kPoseSize + 3) = a.v.template head<6>();
    out.v.template tail<kImuSize>() = a.v.template tail<kImuSize>();
    return out;
  };
  Integral<Jet45> y;
  for (int i = 0; i < 4; ++i) y.q.coeffs()(i) = widened(x.q.coeffs()(i));
  for (int i = 0; i < 3; ++i) {
    y.v(i) = widened(x.v(i));
    y.p(i) = widened(x.p(i));
  }
  return y;
}

void LinkResidual::evaluate_alone(double const* const* parameters, const double* inputs, double* residuals) const {
  using Vector15 = Eigen::Matrix<double, kLinkRows, 1>;
  const Sensor<double> sensor(inputs, R_AI0_);
  Integral<double> x;
  for (const Step& step : steps_) integrate(step, sensor, &x);
  Vector15 r;
  residual(x, parameters[0], parameters[1], parameters[2], parameters[3], r.data());
  Eigen::Map<Vector15>{residuals} = weight_ * (by_scales(inputs) * r);
}

bool LinkResidual::Evaluate(double const* const* parameters, double* residuals, double** jacobians) const {
  double inputs[kIntegralInputs];
  std::copy_n(parameters[1] + 3, 6, inputs);
  std::copy_n(parameters[4], kImuSize, inputs + 6);
  if (!jacobians) {
    evaluate_alone(parameters, inputs, residuals);
    return true;
  }
  static constexpr int kSize[4] = {kPoseSize, kMotionSize, kPoseSize, kMotionSize};
  Jet45 unknowns[kAll];
  for (int b = 0, at = 0; b < 4; at += kSize[b++]) {
    for (int i = 0; i < kSize[b]; ++i) unknowns[at + i] = Jet45(parameters[b][i], at + i);
  }
  Jet45 r[kLinkRows];
  residual(integral_by_unknowns(inputs), unknowns, unknowns + 6, unknowns + 15, unknowns + 21, r);
  Eigen::Matrix<double, kLinkRows, 1> value;
  Eigen::Matrix<double, kLinkRows, kAll> J;
  for (int i = 0; i < kLinkRows; ++i) {
    value(i) = r[i].a;
    J.row(i) = r[i].v.transpose();
  }
  const LinkMatrix scaled = by_scales(inputs);
  J = (scaled * J).eval();
  for (int k = 0; k < 6; ++k) J.col(kAll - kIntegralInputs + scale_input(k)) += by_scale_[k] * value;
  Eigen::Map<Eigen::Matrix<double, kLinkRows, 1>>{residuals} = weight_ * (scaled * value);
  const Eigen::Matrix<double, kLinkRows, kAll> whitened = weight_ * J;
  const auto put = [&](int block, int at, auto width) {
    constexpr int n = decltype(width)::value;
    if (!jacobians[block]) return;
    Eigen::Map<Eigen::Matrix<double, kLinkRows, n, Eigen::RowMajor>>{jacobians[block]} =
        whitened.template middleCols<n>(at);
  };
  put(0, 0, std::integral_constant<int, kPoseSize>());
  put(1, 6, std::integral_constant<int, kMotionSize>());
  put(2, 15, std::integral_constant<int, kPoseSize>());
  put(3, 21, std::integral_constant<int, kMotionSize>());
  put(4, 30, std::integral_constant<int, kImuSize>());
  return true;
}

}  // namespace host::reference
