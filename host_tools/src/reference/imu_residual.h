// IMU residuals: the samples as a smooth signal, integrated with a Runge-Kutta method of fourth order.
#pragma once

#include <ceres/ceres.h>

#include <vector>

#include "reference/camera_residual.h"
#include "reference/link_noise.h"

namespace host::reference {

// Parameter blocks: [v_GI 3 | b_a 3 | b_g 3] of a state, and the IMU's
// [gyro s 3 | gyro m 3 | accel s 3 | accel m 3 | turn of R_AI 3], R_AI = Exp(turn) R0.
constexpr int kMotionSize = 9, kImuSize = 15, kLinkRows = 15;

/// The signal at the beginning, the middle and the end of a step.
struct Step {
  double h = 0;  ///< s
  Eigen::Vector3d gyro[3], accel[3];
};

/// Cuts [t0, t1] at the samples. Between samples the signal is the cubic through the two on either side (at the ends of
/// the samples: through the three nearest).
std::vector<Step> steps_between(const std::vector<ImuSample>& samples, std::int64_t t0_ns, std::int64_t t1_ns);

/// b_a, b_g and the IMU's block as one list, which is what the integral depends on.
constexpr int kIntegralInputs = 6 + kImuSize;

/// Rotation, change of velocity and of position without gravity, in the axes of the first state.
template <class T>
struct Integral {
  Eigen::Quaternion<T> q{T(1), T(0), T(0), T(0)};
  Vector3<T> v = Vector3<T>::Zero(), p = Vector3<T>::Zero();
};

/// x with T x = y, T = [sx mx my; 0 sy mz; 0 0 sz].
template <class T>
Vector3<T> solve_triangle(const T* s, const T* m, const Vector3<T>& y) {
  Vector3<T> x;
  x.z() = y.z() / s[2];
  x.y() = (y.y() - m[2] * x.z()) / s[1];
  x.x() = (y.x() - m[0] * x.y() - m[1] * x.z()) / s[0];
  return x;
}

/// Rotation rate and specific force in I, from raw readings.
template <class T>
struct Sensor {
  const T* input;  ///< kIntegralInputs
  Eigen::Quaternion<T> q_IA;
  Sensor(const T* inputs, const Eigen::Matrix3d& R_AI0)
      : input(inputs), q_IA((turned_by(inputs + 18) * Eigen::Quaterniond(R_AI0).cast<T>()).conjugate()) {}
  Vector3<T> rate(const Eigen::Vector3d& gyro) const {
    return solve_triangle<T>(input + 6, input + 9, gyro.cast<T>() - Eigen::Map<const Vector3<T>>(input + 3));
  }
  Vector3<T> force(const Eigen::Vector3d& accel) const {
    return q_IA * solve_triangle<T>(input + 12, input + 15, accel.cast<T>() - Eigen::Map<const Vector3<T>>(input));
  }
};

/// R' = R [w]x, v' = R f, p' = v over one step.
template <class T>
void integrate(const Step& step, const Sensor<T>& sensor, Integral<T>* x) {
  using Vector4 = Eigen::Matrix<T, 4, 1>;
  const T h(step.h), half(step.h / 2), sixth(step.h / 6);
  const Vector4 q0 = x->q.coeffs();
  const Vector3<T> w[3] = {sensor.rate(step.gyro[0]), sensor.rate(step.gyro[1]), sensor.rate(step.gyro[2])};
  const Vector3<T> f[3] = {sensor.force(step.accel[0]), sensor.force(step.accel[1]), sensor.force(step.accel[2])};
  const auto slope = [](const Vector4& q, const Vector3<T>& rate) -> Vector4 {
    const Eigen::Quaternion<T> product =
        Eigen::Quaternion<T>(q) * Eigen::Quaternion<T>(T(0), rate.x(), rate.y(), rate.z());
    return T(0.5) * product.coeffs();
  };
  const auto rotated = [](const Vector4& q, const Vector3<T>& v) -> Vector3<T> {
    return Eigen::Quaternion<T>(q).normalized() * v;
  };
  const Vector4 k1 = slope(q0, w[0]), q1 = q0 + half * k1;
  const Vector4 k2 = slope(q1, w[1]), q2 = q0 + half * k2;
  const Vector4 k3 = slope(q2, w[1]), q3 = q0 + h * k3;
  const Vector4 k4 = slope(q3, w[2]);
  const Vector3<T> a1 = rotated(q0, f[0]), a2 = rotated(q1, f[1]), a3 = rotated(q2, f[1]), a4 = rotated(q3, f[2]);
  x->p += h * x->v + (h * h / T(6)) * (a1 + a2 + a3);
  x->v += sixth * (a1 + T(2) * (a2 + a3) + a4);
  x->q.coeffs() = q0 + sixth * (k1 + T(2) * (k2 + k3) + k4);
  x->q.normalize();
}

/// By all unknowns of a link.
constexpr int kAll = 2 * (kPoseSize + kMotionSize) + kImuSize;
using Jet45 = ceres::Jet<double, kAll>;

using LinkMatrix = Eigen::Matrix<double, kLinkRows, kLinkRows>;

/// One IMU link, whitened: [rotation | velocity | position | b_a | b_g]. The weights are fixed but for how they follow
/// the sensors' scales s, to first order: P(s)^-1/2 r = W (r + sum_k (s_k - s_k0) / s_k0 P_k P^-1 r), P_k being what
/// axis k's white noise has of the covariance P. Otherwise a scale could make noise small, and nothing would stand
/// against it.
class LinkResidual final
    : public ceres::SizedCostFunction<kLinkRows, kPoseSize, kMotionSize, kPoseSize, kMotionSize, kImuSize> {
 public:
  /// The weights are those at `from` and at the IMU's calibration.
  LinkResidual(const Problem& problem, const Link& link);
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override;

 private:
  Integral<Jet45> integral_by_unknowns(const double* inputs) const;
  void evaluate_alone(double const* const* parameters, const double* inputs, double* residuals) const;
  template <class T>
  void residual(const Integral<T>& integral, const T* pose0, const T* motion0, const T* pose1, const T* motion1,
                T* out) const;
  void weigh(const CoreModel& model, const LinkNoise& white, const double* inputs);
  LinkMatrix by_scales(const double* inputs) const;

  const State &from_, &to_;
  const Eigen::Matrix3d& R_AI0_;
  double dt_, gravity_;
  std::vector<Step> steps_;
  LinkMatrix weight_;       ///< whitened = weight residual
  LinkMatrix by_scale_[6];  ///< P_k P^-1 / s_k of the gyroscope's and the accelerometer's axes
  double scale_[6];         ///< s_k0
};

/// The IMU's block of a calibration, its turn zero.
void imu_block(const ImuCalibration& imu, double* out);

}  // namespace host::reference
