// Inertial model (paper, Sec. III-C) and re-integration of raw samples between two keyframes.
//
// w_m = T_g w_I + b_g + n_g,  a_m = T_a R_AI R_IG (a_G - g) + b_a + n_a.
// The integral over a link is taken in the frame of its first keyframe (dR, dv, dp), with the first-order change of each
// by the biases and the IMU part of theta, and with the noise propagated. Nothing is linearised once and kept: the raw
// samples are integrated again whenever biases or theta have moved.
//
// Terms (effect_terms.h) are taken off the readings: w_I = T_g^-1 (w_m - b_g - e_g), f_A = T_a^-1 (a_m - b_a - e_a), with
// e = sum of c phi at the corrected reading itself: a fixed point. It is iterated twice from e = 0; with q = |d e / d(w, f)|,
// 2 k |w| for a nonlinearity k, 0.02 for a bad sensor at 5 rad/s, what is left is q^2 e, 4e-4 of the term. Derivatives leave
// d phi / d(bias, scale, c) out, a share q of the term's own size: the model is exact, the columns nearly so.
#pragma once

#include "math/block3.h"
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
  S dt;                       ///< s
  Mat3<S> dR;                 ///< R_{I0 I1}
  Vec3<S> dv, dp;             ///< m/s and m, in I0, gravity not included
  Mat<S, 3, kGyroInputs> J_R; ///< right perturbation of dR by the gyroscope inputs
  Mat<S, 3, kInputs> J_v, J_p;
  Mat<S, 9, 9> P;             ///< covariance of (rotation, velocity, position)
  Mat<S, 9, 6> P_b;           ///< covariance of (truth minus integral) with the bias walk (b_a, b_g) over the link
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

/// Integrates readings one after the other in the first keyframe's frame. Rates and forces are linear within a step; the
/// rotation has Magnus' second term (coning), the acceleration is summed by Simpson's rule (sculling). Without these two a
/// shaken device's gyroscope scale is off by a fifth of its sigma.
template <class S>
class ImuIntegrator {
 public:
  ImuIntegrator() = default;   ///< begin() before use
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
  void force_derivative(Mat<S, 3, kInputs>* D) const;
  Mat3<S> turn(const Mat3<S>& dR0, const Mat<S, 3, kGyroInputs>& J_R0, const Vec3<S>& phi, const Mat3<S>& Jr,
               const Mat<S, 3, kGyroInputs>& J_phi);
  void propagate_noise(const Mat3<S>& Et, const Mat3<S>& Jr, const Mat3<S>& V0, const Mat3<S>& V1, const Mat3<S>& RB, S dt);
  void add_walk(const Mat3<S>& Jr, const Mat3<S>& RB, S dt);
  Block3<S> P(int i, int j) { return {I_.P.data() + 27 * j + 3 * i, 1, 9}; }
  Block3<S> P_b(int i, int j) { return {I_.P_b.data() + 27 * j + 3 * i, 1, 9}; }
  const ImuIntegral<S>& complete();

  Mat3<S> T_g_inv_, T_a_inv_, R_IA_, B_;
  Vec3<S> b_a_, b_g_;
  ImuNoise<S> noise_;
  Mat3<S> N_g_;           // density^2 of the rotation rate's noise: n_g stands behind T_g (eq:calib_t)
  Corrected current_;
  Mat<S, 3, kGyroInputs> W_;  // d w_I / d inputs at the current reading
  Mat<S, 3, kInputs> D_;  // d (dR f_I) / d inputs at the current reading
  const EffectTerms<S>* terms_;
  ImuTermColumns<S>* columns_;
  Surroundings<S> surroundings_;
  ImuIntegral<S> I_;
};

/// A term is a function of the true rate and force, and the reading has it on top: x = x_m - c phi(x), a fixed point that each
/// pass approaches by the factor c phi'. At worst, k = 0.017 s/rad at 3 rad/s or k = 6e-3 s^2/m at 10 m/s^2, that is 0.1; two
/// passes left 4 k^3 w^4 of the reading, which moved k by 3 %, seven of its sigmas.
constexpr int kTermPasses = 4;

template <class S>
void ImuIntegrator<S>::begin(const ImuCalibration<S>& imu, const Vec3<S>& b_a, const Vec3<S>& b_g, const ImuNoise<S>& noise,
                             const EffectTerms<S>* terms, ImuTermColumns<S>* columns) {
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
}

template <class S>
void ImuIntegrator<S>::take_off_terms(const InertialReading<S>& r, Corrected* c) const {
  for (int pass = 0; pass < kTermPasses; ++pass) {
    const SignalValues<S> at = signals(*c);
    Vec3<S> gyro = r.gyro - b_g_, accel = r.accel - b_a_;
    for (int i = 0; i < terms_->count(); ++i) {
      if (terms_->term[i].of_imu()) at.add(terms_->term[i], -terms_->value[i], &gyro, &accel);
    }
    c->w_I = T_g_inv_ * gyro;
    c->f_A = T_a_inv_ * accel;
    c->f_I = R_IA_ * c->f_A;
  }
}

/// d w_I / d c of a term of the gyroscope, d f_I / d c of one of the accelerometer.
template <class S>
Vec3<S> ImuIntegrator<S>::term_input(const Term& t, const SignalValues<S>& at) const {
  Vec3<S> gyro = Vec3<S>::Zero(), accel = Vec3<S>::Zero();
  at.add(t, S(-1), &gyro, &accel);
  return t.of_gyro() ? Vec3<S>(T_g_inv_ * gyro) : Vec3<S>(B_ * accel);
}

template <class S>
void ImuIntegrator<S>::start_columns() {
  const SignalValues<S> at = signals(current_);
  for (int i = 0; i < columns_->count(); ++i) {
    columns_->J_R[i].setZero();
    columns_->J_v[i].setZero();
    columns_->J_p[i].setZero();
    columns_->input[i] = term_input(columns_->term[i], at);
    columns_->D[i] = columns_->term[i].of_gyro() ? Vec3<S>::Zero() : columns_->input[i];
  }
}

/// As step() for the other inputs; the integral stands at the step's end already.
template <class S>
void ImuIntegrator<S>::step_columns(const StepFrames& at, S dt) {
  const SignalValues<S> now = signals(current_);
  const Mat3<S> F1 = -(I_.dR * skew(current_.f_I));
  const S half = dt / S(2), eighth = dt / S(8), c = dt * dt / S(12), c_half = dt * dt / S(96);
  const S sixth = dt / S(6), square = dt * dt / S(6);
  for (int i = 0; i < columns_->count(); ++i) {
    const Vec3<S> before = columns_->input[i], D0 = columns_->D[i];
    const Vec3<S> after = columns_->input[i] = term_input(columns_->term[i], now);
    Vec3<S> Dm, D1;
    if (columns_->term[i].of_gyro()) {
      const Vec3<S> J_coning = cross<S>(at.w0, after) - cross<S>(at.w1, before);
      const Vec3<S> J_m = at.Et_m * columns_->J_R[i] + at.Jr_m * (eighth * (S(3) * before + after) + c_half * J_coning);
      columns_->J_R[i] = at.Et * columns_->J_R[i] + at.Jr * (half * (before + after) + c * J_coning);
      Dm = at.F_m * J_m;
      D1 = F1 * columns_->J_R[i];
    } else {
      Dm = at.R_m * (S(0.5) * (before + after));
      D1 = I_.dR * after;
    }
    columns_->D[i] = D1;
    columns_->J_p[i] += dt * columns_->J_v[i] + square * (D0 + S(2) * Dm);
    columns_->J_v[i] += sixth * (D0 + S(4) * Dm + D1);
  }
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
void ImuIntegrator<S>::step(const InertialReading<S>& reading, S dt) {
  const Corrected first = current_, next = corrected(reading);
  const Mat3<S> dR0 = I_.dR;
  const Mat<S, 3, kGyroInputs> J_R0 = I_.J_R, W0 = W_;
  sensor_input_columns(T_g_inv_, next.w_I, W_);
  // Rotation over a stretch h of linear rate, from w0 to w1: h (w0 + w1) / 2 + h^2 (w0 x w1) / 12. Half a step ends at the
  // mean of both.
  const Vec3<S> coning = cross<S>(first.w_I, next.w_I);
  const Mat<S, 3, kGyroInputs> J_coning = skew(first.w_I) * W_ - skew(next.w_I) * W0;
  const S half = dt / S(2), eighth = dt / S(8), c = dt * dt / S(12), c_half = dt * dt / S(96);

  const Vec3<S> phi_m = eighth * (S(3) * first.w_I + next.w_I) + c_half * coning;
  StepFrames frames;
  frames.Jr_m = so3_right_jacobian<S>(phi_m);
  frames.Et_m = turn(dR0, J_R0, phi_m, frames.Jr_m, eighth * (S(3) * W0 + W_) + c_half * J_coning);
  current_.f_A = S(0.5) * (first.f_A + next.f_A);
  current_.f_I = S(0.5) * (first.f_I + next.f_I);
  const Vec3<S> a0 = dR0 * first.f_I, am = I_.dR * current_.f_I;
  const S sixth = dt / S(6), square = dt * dt / S(6);
  Mat<S, 3, kInputs> D;   // at the middle; then what the integral needs of start and middle
  force_derivative(&D);
  I_.J_p += dt * I_.J_v + square * (D_ + S(2) * D);
  D = D_ + S(4) * D;
  if (columns_) {
    frames.R_m = I_.dR;
    frames.F_m = -(I_.dR * skew(current_.f_I));
  }

  const Vec3<S> phi = half * (first.w_I + next.w_I) + c * coning;
  const Mat3<S> Jr = so3_right_jacobian<S>(phi);
  const Mat3<S> Et = turn(dR0, J_R0, phi, Jr, half * (W0 + W_) + c * J_coning);
  current_ = next;
  force_derivative(&D_);
  const Vec3<S> a1 = I_.dR * next.f_I;

  I_.dp += dt * I_.dv + square * (a0 + S(2) * am);
  I_.dv += sixth * (a0 + S(4) * am + a1);
  I_.J_v += sixth * (D + D_);
  if (columns_) {
    frames.Et = Et;
    frames.Jr = Jr;
    frames.w0 = first.w_I;
    frames.w1 = next.w_I;
    step_columns(frames, dt);
  }
  propagate_noise(Et, Jr, dR0 * skew(first.f_I), I_.dR * skew(next.f_I), dR0 * B_, dt);
  I_.dt += dt;
}

/// P <- F P F' + Q with F = [Et 0 0; Fv I 0; Fp dt I], and the bias walk carried along in P_b. P is symmetric and only its
/// blocks on and above the diagonal are kept; complete() makes the others. In place, one row of F after the other, the last
/// first: it needs the old ones above.
template <class S>
void ImuIntegrator<S>::propagate_noise(const Mat3<S>& Et, const Mat3<S>& Jr, const Mat3<S>& V0, const Mat3<S>& V1,
                                       const Mat3<S>& RB, S dt) {
  const Mat3<S> V1Et = product(V1, Et);
  const Mat3<S> Fv = -(dt / S(2)) * (V0 + V1Et);
  const Mat3<S> Fp = -(dt * dt / S(3)) * V0 - (dt * dt / S(6)) * V1Et;
  const Block3<S> RR = P(0, 0), RV = P(0, 1), RP = P(0, 2), VV = P(1, 1), VP = P(1, 2), PP = P(2, 2), Fpt = Block3<S>(Fp).transpose(),
                  Fvt = Block3<S>(Fv).transpose();
  PP.add_product(Fp, RP);  // p <- p + Fp r + dt v
  PP.add_scaled(dt, VP);
  RP.add_product(RR, Fpt);
  RP.add_scaled(dt, RV);
  VP.add_product(RV.transpose(), Fpt);
  VP.add_scaled(dt, VV);
  PP.add_product(RP.transpose(), Fpt);
  PP.add_scaled(dt, VP.transpose());
  VV.add_product(Fv, RV);  // v <- v + Fv r
  RV.add_product(RR, Fvt);
  VP.add_product(Fv, RP);
  VV.add_product(RV.transpose(), Fvt);
  for (const Block3<S>& block : {RR, RR.transpose(), RV, RP}) block.multiply_left(Et);  // r <- Et r
  P_b(2, 1).add_product(Fp, P_b(0, 1));
  P_b(2, 1).add_scaled(dt, P_b(1, 1));
  P_b(2, 0).add_scaled(dt, P_b(1, 0));
  P_b(1, 1).add_product(Fv, P_b(0, 1));
  P_b(0, 1).multiply_left(Et);
  add_walk(Jr, RB, dt);
}

/// What the step's own noise adds, and the walk of the biases: after t seconds it has variance sigma^2 t. A bias moves the
/// rotation by G_R (b_g), the velocity by G_v and the position by dt / 2 G_v (b_a); no rotation follows from b_a.
template <class S>
void ImuIntegrator<S>::add_walk(const Mat3<S>& Jr, const Mat3<S>& RB, S dt) {
  const Mat3<S> G_R = -dt * product(Jr, T_g_inv_), G_v = -dt * RB;
  const Block3<S> G_Rt = Block3<S>(G_R).transpose(), G_vt = Block3<S>(G_v).transpose();
  const S va = noise_.accel_walk * noise_.accel_walk * I_.dt, vg = noise_.gyro_walk * noise_.gyro_walk * I_.dt, half = dt / S(2);
  Mat3<S> storage;
  const Block3<S> X(storage);
  const auto set_product = [&](const Block3<S>& A, const Block3<S>& B) {
    storage.setZero();
    X.add_product(A, B);
  };
  // What the walk so far and this step have in common: P += C G' + G C', C = P_b.
  set_product(P_b(0, 1), G_Rt);
  P(0, 0).add_scaled(S(1), X);
  P(0, 0).add_scaled(S(1), X.transpose());
  P(0, 1).add_product(G_R, P_b(1, 1).transpose());
  P(0, 2).add_product(G_R, P_b(2, 1).transpose());
  set_product(P_b(1, 0), G_vt);
  P(1, 1).add_scaled(S(1), X);
  P(1, 1).add_scaled(S(1), X.transpose());
  P(1, 2).add_scaled(half, X);
  set_product(P_b(2, 0), G_vt);
  P(1, 2).add_scaled(S(1), X.transpose());
  P(2, 2).add_scaled(half, X);
  P(2, 2).add_scaled(half, X.transpose());
  // The walk so far moves this step, and the white noise does: the accelerometer's moves what its bias moves.
  set_product(G_R, G_Rt);
  P(0, 0).add_scaled(vg, X);
  P(0, 0).add_scaled(dt, N_g_);
  set_product(G_v, G_vt);
  const S na = noise_.accel * noise_.accel / dt;
  P(1, 1).add_scaled(va + na, X);
  P(1, 2).add_scaled(half * (va + na), X);
  P(2, 2).add_scaled(dt * dt * (va / S(4) + na / S(3)), X);
  P_b(0, 1).add_scaled(vg, G_R);
  P_b(1, 0).add_scaled(va, G_v);
  P_b(2, 0).add_scaled(va * half, G_v);
}

/// The blocks below the diagonal, once for the link.
template <class S>
const ImuIntegral<S>& ImuIntegrator<S>::complete() {
  for (int j = 0; j < 9; ++j) {
    for (int i = j + 1; i < 9; ++i) I_.P(i, j) = I_.P(j, i);
  }
  return I_;
}

}  // namespace SEGCAL_NS
