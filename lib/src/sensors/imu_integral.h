// Inertial model (paper, Sec. III-C) and re-integration of raw samples between two keyframes.
//
// w_m = T_g w_I + b_g + n_g,  a_m = T_a R_AI R_IG (a_G - g) + b_a + n_a.
// The integral over a link is taken in the frame of its first keyframe (dR, dv, dp), with the first-order change of
// each by the biases and the IMU part of theta, and with the noise propagated. Nothing is linearised once and kept: the
// raw samples are integrated again whenever biases or theta have moved.
//
// Terms (effect_terms.h) are taken off the readings: w_I = T_g^-1 (w_m - b_g - e_g), f_A = T_a^-1
// (a_m - b_a - e_a), with e = sum of c phi at the corrected reading itself: a fixed point. It is
// iterated twice from e = 0; with q = |d e / d(w, f)|, 2 k |w| for a nonlinearity k, 0.02 for a bad
// sensor at 5 rad/s, what is left is q^2 e, 4e-4 of the term. Derivatives leave d phi / d(bias,
// scale, c) out, a share q of the term's own size: the model is exact, the columns nearly so.
#pragma once

#include "math/block3.h"
#include "math/near.h"
#include "sensors/calibration.h"
#include "sensors/imu_terms.h"
#include "sensors/inertial_state.h"

namespace SEGCAL_NS {

/// Inverse of the upper triangular T.
template <class S>
Mat3<S> inverse_scale_misalignment(const Vec3<S>& s, const Vec3<S>& m) {
  const S ix = S(1) / s.x(), iy = S(1) / s.y(), iz = S(1) / s.z();
  Mat3<S> T;
  T << ix, -m.x() * ix * iy, (m.x() * m.z() * iy - m.y()) * ix * iz, S(0), iy, -m.z() * iy * iz, S(0), S(0), iz;
  return T;
}

// Input columns: everything that changes the integral. The gyroscope's nine come first.
constexpr int kInputBg = 0, kInputGyroScale = 3, kInputGyroMisalignment = 6, kGyroInputs = 9;
constexpr int kInputBa = 9, kInputAccelScale = 12, kInputAccelMisalignment = 15, kInputRai = 18, kInputs = 21;

/// The integral over a link and all that is needed to linearise it.
template <class S>
struct ImuIntegral {
  S dt;                        ///< s
  Mat3<S> dR;                  ///< R_{I0 I1}
  Vec3<S> dv, dp;              ///< m/s and m, in I0, gravity not included
  Mat<S, 3, kGyroInputs> J_R;  ///< right perturbation of dR by the gyroscope inputs
  Mat<S, 3, kInputs> J_v, J_p;
  Mat<S, 9, 9> P;    ///< covariance of (rotation, velocity, position)
  Mat<S, 9, 6> P_b;  ///< covariance of (truth minus integral) with the bias walk (b_a, b_g) over the link
  S accel_density2;  ///< (m/s^2)^2/Hz, of the accelerometer's white noise in P
};

/// Columns of d w_I or d f_A by (bias, scale, misalignment): -M [I | diag(x) | mixed(x)], x the corrected reading.
template <class S, class Out>
void sensor_input_columns(const Mat3<S>& M, const Vec3<S>& x, Out&& out) {
  for (int i = 0; i < 3; ++i) {
    out.col(i) = -M.col(i);
    out.col(3 + i) = -M.col(i) * x(i);
  }
  out.col(6) = -M.col(0) * x.y();
  out.col(7) = -M.col(0) * x.z();
  out.col(8) = -M.col(1) * x.z();
}

/// Integrates readings one after the other in the first keyframe's frame. Rates and forces are linear within a step;
/// the rotation has Magnus' second term (coning), the acceleration is summed by Simpson's rule (sculling). Without
/// these two a shaken device's gyroscope scale is off by a fifth of its sigma.
template <class S>
class ImuIntegrator {
 public:
  ImuIntegrator() = default;  ///< begin() before use
  ImuIntegrator(const ImuCalibration<S>& imu, const Vec3<S>& b_a, const Vec3<S>& b_g, const ImuNoise<S>& noise,
                const EffectTerms<S>* terms = nullptr, ImuTermColumns<S>* columns = nullptr) {
    begin(imu, b_a, b_g, noise, terms, columns);
  }
  /// `terms`: taken off the readings; null: none. `columns`: derivatives wanted, with their memory; null: none.
  void begin(const ImuCalibration<S>& imu, const Vec3<S>& b_a, const Vec3<S>& b_g, const ImuNoise<S>& noise,
             const EffectTerms<S>* terms = nullptr, ImuTermColumns<S>* columns = nullptr);

  /// True if terms need to know what is beside each reading: surroundings() is to be set before start() and step().
  bool wants_surroundings() const { return kMaxEffectColumns > 0 && (terms_ || columns_); }
  Surroundings<S>* surroundings() { return &surroundings_; }
  /// I's x axis dt seconds from now, at the present rate, in the axes of I at the start.
  Vec3<S> x_axis_after(S dt) const { return I_.dR * Vec3<S>(S(1), dt * current_.w_I(2), -dt * current_.w_I(1)); }
  /// Of Signal::time.
  std::int64_t time_zero_ns() const { return terms_ ? terms_->time_zero_ns : 0; }

  /// The reading at the first keyframe's time.
  void start(const InertialReading<S>& reading) {
    current_ = corrected(reading);
    sensor_input_columns(T_g_inv_, current_.w_I, W_);
    force_derivative(&D_);
    if (columns_) start_columns();
  }

  /// The next reading, dt seconds later (dt > 0).
  void step(const InertialReading<S>& reading, S dt);

  const ImuIntegral<S>& result() { return complete(); }
  void take(const ImuIntegral<S>& earlier) { I_ = earlier; }  ///< stands where an earlier integration ended

 private:
  struct Corrected {
    Vec3<S> w_I, f_A, f_I;
  };
  Corrected corrected(const InertialReading<S>& r) const {
    Corrected c;
    c.w_I = T_g_inv_ * (r.gyro - b_g_);
    c.f_A = T_a_inv_ * (r.accel - b_a_);
    c.f_I = R_IA_ * c.f_A;
    if (terms_) take_off_terms(r, &c);
    return c;
  }
  void take_off_terms(const InertialReading<S>& r, Corrected* c) const;
  SignalValues<S> signals(const Corrected& c) const { return {c.w_I, c.f_I, c.f_A, T_g_inv_, surroundings_}; }
  Vec3<S> term_input(const Term& t, const SignalValues<S>& at) const;
  void start_columns();
  /// What one step has at its middle and at its end, for the columns of terms.
  struct StepFrames {
    Mat3<S> Et_m, Jr_m, R_m, F_m, Et, Jr;  ///< F = -dR [f]x
    Vec3<S> w0, w1;
  };
  void step_columns(const StepFrames& at, S dt);
  /// Rotation over the first half of a step and over all of it, with derivatives. Over a stretch h of linear rate, from
  /// w0 to w1, it is h (w0 + w1) / 2 + h^2 (w0 x w1) / 12; half a step ends at the mean of both.
  struct StepRotation {
    Vec3<S> phi_m, phi;
    Mat<S, 3, kGyroInputs> J_m, J;
  };
  static StepRotation rotation_over(const Vec3<S>& w0, const Vec3<S>& w1, const Mat<S, 3, kGyroInputs>& W0,
                                    const Mat<S, 3, kGyroInputs>& W1, S dt);
  void force_derivative(Mat<S, 3, kInputs>* D) const;
  Mat3<S> turn(const Mat3<S>& dR0, const Mat<S, 3, kGyroInputs>& J_R0, const Vec3<S>& phi, const Mat3<S>& Jr,
               const Mat<S, 3, kGyroInputs>& J_phi);
  void propagate_noise(const Mat3<S>& Et, const Mat3<S>& Jr, const Mat3<S>& V0, const Mat3<S>& V1, const Mat3<S>& RB,
                       S dt);
  void add_walk(const Mat3<S>& Jr, const Mat3<S>& RB, S dt);
  Block3<S> P(int i, int j) { return {I_.P.data() + 27 * j + 3 * i, 1, 9}; }
  Block3<S> P_b(int i, int j) { return {I_.P_b.data() + 27 * j + 3 * i, 1, 9}; }
  const ImuIntegral<S>& complete();

  Mat3<S> T_g_inv_, T_a_inv_, R_IA_, B_;
  Vec3<S> b_a_, b_g_;
  ImuNoise<S> noise_;
  Mat3<S> N_g_;  // density^2 of the rotation rate's noise: n_g stands behind T_g (eq:calib_t)
  Corrected current_;
  Mat<S, 3, kGyroInputs> W_;  // d w_I / d inputs at the current reading
  Mat<S, 3, kInputs> D_;      // d (dR f_I) / d inputs at the current reading
  NearOrNull<const EffectTerms<S>> terms_;
  NearOrNull<ImuTermColumns<S>> columns_;
  Surroundings<S> surroundings_;
  ImuIntegral<S> I_;
};

template <class S>
void ImuIntegrator<S>::begin(const ImuCalibration<S>& imu, const Vec3<S>& b_a, const Vec3<S>& b_g,
                             const ImuNoise<S>& noise, const EffectTerms<S>* terms, ImuTermColumns<S>* columns) {
  T_g_inv_ = inverse_scale_misalignment(imu.gyro_scale, imu.gyro_misalignment);
  T_a_inv_ = inverse_scale_misalignment(imu.accel_scale, imu.accel_misalignment);
  R_IA_ = imu.R_AI.transpose();
  B_ = R_IA_ * T_a_inv_;
  b_a_ = b_a;
  b_g_ = b_g;
  noise_ = noise;
  N_g_ = noise.gyro * noise.gyro * (T_g_inv_ * T_g_inv_.transpose());
  terms_ = terms && terms->any_of_imu() ? terms : nullptr;
  columns_ = columns && columns->count() > 0 ? columns : nullptr;
  surroundings_ = Surroundings<S>{};
  current_.w_I.setZero();
  I_.dt = S(0);
  I_.dR.setIdentity();
  I_.dv.setZero();
  I_.dp.setZero();
  I_.J_R.setZero();
  I_.J_v.setZero();
  I_.J_p.setZero();
  I_.P.setZero();
  I_.P_b.setZero();
  I_.accel_density2 = noise.accel * noise.accel;
}

template <class S>
void ImuIntegrator<S>::force_derivative(Mat<S, 3, kInputs>* D) const {
  const Mat3<S> M = I_.dR * B_;
  D->template leftCols<kGyroInputs>().noalias() = -(I_.dR * skew(current_.f_I)) * I_.J_R;
  sensor_input_columns(M, current_.f_A, D->template middleCols<9>(kInputBa));
  // R_AI <- Exp(d) R_AI: f_I = R_AI' Exp(-d) f_A, so d f_I = R_AI' [f_A]x d.
  D->template middleCols<3>(kInputRai).noalias() = (I_.dR * R_IA_) * skew(current_.f_A);
}

/// Places the integral's rotation at dR0 Exp(phi), with its derivative; returns Exp(-phi). `Jr`: right Jacobian at phi.
template <class S>
Mat3<S> ImuIntegrator<S>::turn(const Mat3<S>& dR0, const Mat<S, 3, kGyroInputs>& J_R0, const Vec3<S>& phi,
                               const Mat3<S>& Jr, const Mat<S, 3, kGyroInputs>& J_phi) {
  const Mat3<S> E = so3_exp<S>(phi), Et = E.transpose();
  I_.J_R = Et * J_R0 + Jr * J_phi;
  I_.dR = dR0 * E;
  return Et;
}

template <class S>
typename ImuIntegrator<S>::StepRotation ImuIntegrator<S>::rotation_over(const Vec3<S>& w0, const Vec3<S>& w1,
                                                                        const Mat<S, 3, kGyroInputs>& W0,
                                                                        const Mat<S, 3, kGyroInputs>& W1, S dt) {
  const Vec3<S> coning = cross<S>(w0, w1);
  const Mat<S, 3, kGyroInputs> J_coning = skew(w0) * W1 - skew(w1) * W0;
  const S half = dt / S(2), eighth = dt / S(8), c = dt * dt / S(12), c_half = dt * dt / S(96);
  return {eighth * (S(3) * w0 + w1) + c_half * coning, half * (w0 + w1) + c * coning,
          eighth * (S(3) * W0 + W1) + c_half * J_coning, half * (W0 + W1) + c * J_coning};
}

template <class S>
void ImuIntegrator<S>::step(const InertialReading<S>& reading, S dt) {
  const Corrected first = current_, next = corrected(reading);
  const Mat3<S> dR0 = I_.dR;
  const Mat<S, 3, kGyroInputs> J_R0 = I_.J_R, W0 = W_;
  sensor_input_columns(T_g_inv_, next.w_I, W_);
  const StepRotation over = rotation_over(first.w_I, next.w_I, W0, W_, dt);
  const S sixth = dt / S(6), square = dt * dt / S(6);

  StepFrames frames;
  frames.w0 = first.w_I;
  frames.w1 = next.w_I;
  frames.Jr_m = so3_right_jacobian<S>(over.phi_m);
  frames.Et_m = turn(dR0, J_R0, over.phi_m, frames.Jr_m, over.J_m);
  current_.f_A = S(0.5) * (first.f_A + next.f_A);
  current_.f_I = S(0.5) * (first.f_I + next.f_I);
  const Vec3<S> a0 = dR0 * first.f_I, am = I_.dR * current_.f_I;
  Mat<S, 3, kInputs> D;  // at the middle; then what the integral needs of start and middle
  force_derivative(&D);
  I_.J_p += dt * I_.J_v + square * (D_ + S(2) * D);
  D = D_ + S(4) * D;
  if (columns_) {
    frames.R_m = I_.dR;
    frames.F_m = -(I_.dR * skew(current_.f_I));
  }

  frames.Jr = so3_right_jacobian<S>(over.phi);
  frames.Et = turn(dR0, J_R0, over.phi, frames.Jr, over.J);
  current_ = next;
  force_derivative(&D_);
  const Vec3<S> a1 = I_.dR * next.f_I;
  I_.dp += dt * I_.dv + square * (a0 + S(2) * am);
  I_.dv += sixth * (a0 + S(4) * am + a1);
  I_.J_v += sixth * (D + D_);
  if (columns_) step_columns(frames, dt);
  propagate_noise(frames.Et, frames.Jr, dR0 * skew(first.f_I), I_.dR * skew(next.f_I), dR0 * B_, dt);
  I_.dt += dt;
}

}  // namespace SEGCAL_NS

#include "sensors/imu_integral_noise.h"
#include "sensors/imu_integral_terms.h"
