// Inertial model (paper, Sec. III-C) and re-integration of raw samples between two keyframes.
//
// w_m = T_g w_I + b_g + n_g,  a_m = T_a R_AI R_IG (a_G - g) + b_a + n_a.
// The integral over a link is taken in the frame of its first keyframe (dR, dv, dp), with the first-order change of each
// by the biases and the IMU part of theta, and with the noise propagated. Nothing is linearised once and kept: the raw
// samples are integrated again whenever biases or theta have moved.
#pragma once

#include "math/qr.h"
#include "math/so3.h"
#include "sensors/calibration.h"

namespace SEGCAL_NS {

/// State of a keyframe. Error columns: [theta 3 | p 3 | v 3 | b_a 3 | b_g 3], R <- R Exp(theta), the rest added.
template <class S>
struct State {
  Mat3<S> R_GI = Mat3<S>::Identity();
  Vec3<S> p_GI = Vec3<S>::Zero();  ///< m
  Vec3<S> v_GI = Vec3<S>::Zero();  ///< m/s
  Vec3<S> b_a = Vec3<S>::Zero();   ///< m/s^2
  Vec3<S> b_g = Vec3<S>::Zero();   ///< rad/s

  void add(const S* d) {
    R_GI = renormalised<S>(R_GI * so3_exp<S>(Vec3<S>(d[0], d[1], d[2])));
    p_GI += Vec3<S>(d[3], d[4], d[5]);
    v_GI += Vec3<S>(d[6], d[7], d[8]);
    b_a += Vec3<S>(d[9], d[10], d[11]);
    b_g += Vec3<S>(d[12], d[13], d[14]);
  }
};
constexpr int kStateColumns = 15;
constexpr int kPoseColumns = 6;  ///< the first six: theta and p

/// Continuous-time noise densities.
template <class S>
struct ImuNoise {
  S gyro = S(1.7e-4);        ///< rad/s/sqrt(Hz)
  S gyro_walk = S(2e-5);     ///< rad/s^2/sqrt(Hz)
  S accel = S(2e-3);         ///< m/s^2/sqrt(Hz)
  S accel_walk = S(3e-4);    ///< m/s^3/sqrt(Hz)
};

/// One raw sample as the integration sees it.
template <class S>
struct InertialReading {
  Vec3<S> gyro, accel;  ///< rad/s, m/s^2
};

/// Linear interpolation between two readings, u in [0, 1].
template <class S>
InertialReading<S> interpolate(const InertialReading<S>& a, const InertialReading<S>& b, S u) {
  return {a.gyro + u * (b.gyro - a.gyro), a.accel + u * (b.accel - a.accel)};
}

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
  ImuIntegrator(const ImuCalibration<S>& imu, const Vec3<S>& b_a, const Vec3<S>& b_g, const ImuNoise<S>& noise)
      : T_g_inv_(inverse_scale_misalignment(imu.gyro_scale, imu.gyro_misalignment)),
        T_a_inv_(inverse_scale_misalignment(imu.accel_scale, imu.accel_misalignment)),
        R_IA_(imu.R_AI.transpose()),
        B_(R_IA_ * T_a_inv_),
        b_a_(b_a),
        b_g_(b_g),
        noise_(noise),
        N_g_(noise.gyro * noise.gyro * (T_g_inv_ * T_g_inv_.transpose())) {
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

  /// The reading at the first keyframe's time.
  void start(const InertialReading<S>& reading) {
    current_ = corrected(reading);
    sensor_input_columns(T_g_inv_, current_.w_I, W_);
    force_derivative(&D_);
  }

  /// The next reading, dt seconds later (dt > 0).
  void step(const InertialReading<S>& reading, S dt);

  const ImuIntegral<S>& result() const { return I_; }

 private:
  struct Corrected {
    Vec3<S> w_I, f_A, f_I;
  };
  Corrected corrected(const InertialReading<S>& r) const {
    Corrected c;
    c.w_I = T_g_inv_ * (r.gyro - b_g_);
    c.f_A = T_a_inv_ * (r.accel - b_a_);
    c.f_I = R_IA_ * c.f_A;
    return c;
  }
  void force_derivative(Mat<S, 3, kInputs>* D) const;
  Mat3<S> turn(const Mat3<S>& dR0, const Mat<S, 3, kGyroInputs>& J_R0, const Vec3<S>& phi, const Mat3<S>& Jr,
               const Mat<S, 3, kGyroInputs>& J_phi);
  void propagate_noise(const Mat3<S>& Et, const Mat3<S>& Jr, const Mat3<S>& V0, const Mat3<S>& V1, const Mat3<S>& RB, S dt);

  Mat3<S> T_g_inv_, T_a_inv_, R_IA_, B_;
  Vec3<S> b_a_, b_g_;
  ImuNoise<S> noise_;
  Mat3<S> N_g_;           // density^2 of the rotation rate's noise: n_g stands behind T_g (eq:calib_t)
  Corrected current_;
  Mat<S, 3, kGyroInputs> W_;  // d w_I / d inputs at the current reading
  Mat<S, 3, kInputs> D_;  // d (dR f_I) / d inputs at the current reading
  ImuIntegral<S> I_;
};

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
  const Mat<S, 3, kInputs> D0 = D_;
  sensor_input_columns(T_g_inv_, next.w_I, W_);
  // Rotation over a stretch h of linear rate, from w0 to w1: h (w0 + w1) / 2 + h^2 (w0 x w1) / 12. Half a step ends at the
  // mean of both.
  const Vec3<S> coning = cross<S>(first.w_I, next.w_I);
  const Mat<S, 3, kGyroInputs> J_coning = skew(first.w_I) * W_ - skew(next.w_I) * W0;
  const S half = dt / S(2), eighth = dt / S(8), c = dt * dt / S(12), c_half = dt * dt / S(96);

  const Vec3<S> phi_m = eighth * (S(3) * first.w_I + next.w_I) + c_half * coning;
  turn(dR0, J_R0, phi_m, so3_right_jacobian<S>(phi_m), eighth * (S(3) * W0 + W_) + c_half * J_coning);
  current_.f_A = S(0.5) * (first.f_A + next.f_A);
  current_.f_I = S(0.5) * (first.f_I + next.f_I);
  const Vec3<S> a0 = dR0 * first.f_I, am = I_.dR * current_.f_I;
  Mat<S, 3, kInputs> Dm;
  force_derivative(&Dm);

  const Vec3<S> phi = half * (first.w_I + next.w_I) + c * coning;
  const Mat3<S> Jr = so3_right_jacobian<S>(phi);
  const Mat3<S> Et = turn(dR0, J_R0, phi, Jr, half * (W0 + W_) + c * J_coning);
  current_ = next;
  force_derivative(&D_);
  const Vec3<S> a1 = I_.dR * next.f_I;

  const S sixth = dt / S(6), square = dt * dt / S(6);
  I_.dp += dt * I_.dv + square * (a0 + S(2) * am);
  I_.J_p += dt * I_.J_v + square * (D0 + S(2) * Dm);
  I_.dv += sixth * (a0 + S(4) * am + a1);
  I_.J_v += sixth * (D0 + S(4) * Dm + D_);
  propagate_noise(Et, Jr, dR0 * skew(first.f_I), I_.dR * skew(next.f_I), dR0 * B_, dt);
  I_.dt += dt;
}

/// P <- F P F' + Q with F = [Et 0 0; Fv I 0; Fp dt I], and the bias walk carried along in P_b:
/// after t seconds the walk has variance sigma^2 t, and G is what a bias moves in this step.
template <class S>
void ImuIntegrator<S>::propagate_noise(const Mat3<S>& Et, const Mat3<S>& Jr, const Mat3<S>& V0, const Mat3<S>& V1,
                                       const Mat3<S>& RB, S dt) {
  const Mat3<S> Fv = -(dt / S(2)) * (V0 + V1 * Et);
  const Mat3<S> Fp = -(dt * dt / S(3)) * V0 - (dt * dt / S(6)) * (V1 * Et);
  const Mat3<S> G_R = -dt * (Jr * T_g_inv_);                 // rotation by b_g
  const Mat3<S> G_v = -dt * RB, G_p = -(dt * dt / S(2)) * RB;  // velocity, position by b_a
  const S va = noise_.accel_walk * noise_.accel_walk * I_.dt, vg = noise_.gyro_walk * noise_.gyro_walk * I_.dt;

  Mat<S, 9, 9>& P = I_.P;
  Mat<S, 9, 6>& C = I_.P_b;
  const auto left = [&](auto& M) {  // M <- F M, bottom rows first: they read the old ones above
    M.template middleRows<3>(6) += (Fp * M.template topRows<3>() + dt * M.template middleRows<3>(3)).eval();
    M.template middleRows<3>(3) += (Fv * M.template topRows<3>()).eval();
    M.template topRows<3>() = (Et * M.template topRows<3>()).eval();
  };
  left(P);
  Mat<S, 9, 9> Pt = P.transpose();
  left(Pt);
  P = Pt;
  left(C);
  // Cross terms of the walk so far with this step, and its own contribution.
  Mat<S, 9, 6> G = Mat<S, 9, 6>::Zero();
  G.template block<3, 3>(0, 3) = G_R;
  G.template block<3, 3>(3, 0) = G_v;
  G.template block<3, 3>(6, 0) = G_p;
  Mat<S, 9, 6> GB = G;
  GB.template leftCols<3>() *= va;
  GB.template rightCols<3>() *= vg;
  // lazyProduct: beyond 8 rows Eigen would take its blocked product, which allocates.
  const Mat<S, 9, 9> X = C.lazyProduct(G.transpose());
  P += X + X.transpose() + GB.lazyProduct(G.transpose());
  C += GB;

  const Mat3<S> N_a = (noise_.accel * noise_.accel * dt) * (RB * RB.transpose());
  P.template block<3, 3>(0, 0) += dt * N_g_;
  P.template block<3, 3>(3, 3) += N_a;
  P.template block<3, 3>(6, 6) += (dt * dt / S(3)) * N_a;
  P.template block<3, 3>(3, 6) += (dt / S(2)) * N_a;
  P.template block<3, 3>(6, 3) += (dt / S(2)) * N_a;
}

/// Residual of a link, whitened, with Jacobians; paper, Sec. IV-C. Rows: rotation, velocity, position, b_a, b_g.
/// J: [state0 15 | state1 15 | imu theta 15].
template <class S>
struct ImuRows {
  Vec<S, 15> r;
  Eigen::Matrix<S, 15, 2 * kStateColumns + kImuColumns, Eigen::RowMajor> J;
};

/// Covariance of the link's 15 residuals: P with the walk of both biases over dt.
template <class S>
Mat<S, 15, 15> link_covariance(const ImuIntegral<S>& I, const ImuNoise<S>& noise) {
  Mat<S, 15, 15> Q = Mat<S, 15, 15>::Zero();
  Q.template topLeftCorner<9, 9>() = I.P;
  // Residual and P_b are both "truth minus integral": a bias that has grown by b1 - b0 makes the integral too large.
  Q.template topRightCorner<9, 6>() = I.P_b;
  Q.template bottomLeftCorner<6, 9>() = I.P_b.transpose();
  for (int i = 0; i < 3; ++i) {
    Q(9 + i, 9 + i) = noise.accel_walk * noise.accel_walk * I.dt;
    Q(12 + i, 12 + i) = noise.gyro_walk * noise.gyro_walk * I.dt;
  }
  return Q;
}

/// Residual r = (Log(dR' R0' R1), R0'(v1 - v0 - g dt) - dv, R0'(p1 - p0 - v0 dt - g dt^2/2) - dp, b1 - b0), not whitened.
template <class S>
Vec<S, 15> link_residual(const ImuIntegral<S>& I, const State<S>& x0, const State<S>& x1, const Vec3<S>& g) {
  Vec<S, 15> r;
  const Mat3<S> R0t = x0.R_GI.transpose();
  r.template segment<3>(0) = so3_log<S>(I.dR.transpose() * (R0t * x1.R_GI));
  r.template segment<3>(3) = R0t * (x1.v_GI - x0.v_GI - g * I.dt) - I.dv;
  r.template segment<3>(6) = R0t * (x1.p_GI - x0.p_GI - x0.v_GI * I.dt - g * (I.dt * I.dt / S(2))) - I.dp;
  r.template segment<3>(9) = x1.b_a - x0.b_a;
  r.template segment<3>(12) = x1.b_g - x0.b_g;
  return r;
}

/// Fills residual and Jacobians, not whitened. `j0`, `j1` are the states at which the Jacobian is taken (the same as x0,
/// x1 except in a filter that keeps first estimates).
template <class S>
void link_rows(const ImuIntegral<S>& I, const State<S>& x0, const State<S>& x1, const State<S>& j0, const State<S>& j1,
               const Vec3<S>& g, ImuRows<S>* rows) {
  rows->r = link_residual(I, x0, x1, g);
  auto& J = rows->J;
  J.setZero();
  const Mat3<S> R0t = j0.R_GI.transpose(), R01 = R0t * j1.R_GI;
  const Vec3<S> r_R = rows->r.template head<3>();
  const Mat3<S> Jri = so3_right_jacobian_inverse<S>(r_R);
  const Vec3<S> dv = R0t * (j1.v_GI - j0.v_GI - g * I.dt);
  const Vec3<S> dp = R0t * (j1.p_GI - j0.p_GI - j0.v_GI * I.dt - g * (I.dt * I.dt / S(2)));
  const Mat3<S> Jt = so3_right_jacobian_inverse<S>(Vec3<S>(-r_R));  // left Jacobian inverse
  constexpr int x1c = kStateColumns, th = 2 * kStateColumns;
  J.template block<3, 3>(0, 0) = -Jri * R01.transpose();
  J.template block<3, 3>(0, x1c) = Jri;
  J.template block<3, 3>(3, 0) = skew(dv);
  J.template block<3, 3>(3, 6) = -R0t;
  J.template block<3, 3>(3, x1c + 6) = R0t;
  J.template block<3, 3>(6, 0) = skew(dp);
  J.template block<3, 3>(6, 3) = -R0t;
  J.template block<3, 3>(6, 6) = -R0t * I.dt;
  J.template block<3, 3>(6, x1c + 3) = R0t;
  // Log((dR Exp(e))' ...) changes by -J_l^-1(r) e.
  J.template block<3, 3>(0, 12) = -Jt * I.J_R.template leftCols<3>();
  J.template block<3, 6>(0, th) = -Jt * I.J_R.template rightCols<6>();
  J.template block<3, 3>(3, 12) = -I.J_v.template middleCols<3>(kInputBg);
  J.template block<3, 3>(3, 9) = -I.J_v.template middleCols<3>(kInputBa);
  J.template block<3, 6>(3, th) = -I.J_v.template middleCols<6>(kInputGyroScale);
  J.template block<3, 9>(3, th + 6) = -I.J_v.template middleCols<9>(kInputAccelScale);
  J.template block<3, 3>(6, 12) = -I.J_p.template middleCols<3>(kInputBg);
  J.template block<3, 3>(6, 9) = -I.J_p.template middleCols<3>(kInputBa);
  J.template block<3, 6>(6, th) = -I.J_p.template middleCols<6>(kInputGyroScale);
  J.template block<3, 9>(6, th + 6) = -I.J_p.template middleCols<9>(kInputAccelScale);
  for (int i = 0; i < 6; ++i) {
    J(9 + i, 9 + i) = S(-1);
    J(9 + i, x1c + 9 + i) = S(1);
  }
}

/// Square root of the link's information: a scale per row and a lower triangle, so that whitened = L^-1 (scale r).
template <class S>
struct LinkWhitening {
  Vec<S, 15> scale;
  Mat<S, 15, 15> L;
};

/// False if the covariance is not positive (a link of no duration). Scaled to unit diagonal first: the entries span ten
/// decades, and float keeps seven digits of each ratio.
template <class S>
bool link_whitening(const ImuIntegral<S>& I, const ImuNoise<S>& noise, LinkWhitening<S>* w) {
  Mat<S, 15, 15> Q = link_covariance(I, noise);
  for (int i = 0; i < 15; ++i) {
    if (!(Q(i, i) > S(0))) return false;
    w->scale(i) = S(1) / square_root(Q(i, i));
  }
  for (int j = 0; j < 15; ++j) {
    for (int i = 0; i < 15; ++i) Q(i, j) = (Q(i, j) * w->scale(i)) * w->scale(j);
  }
  return cholesky_lower<S, 15>(Q, &w->L);
}

/// Whitens the residual alone.
template <class S>
bool whiten_residual(const ImuIntegral<S>& I, const ImuNoise<S>& noise, const Vec<S, 15>& r, Vec<S, 15>* out) {
  LinkWhitening<S> w;
  if (!link_whitening(I, noise, &w)) return false;
  for (int i = 0; i < 15; ++i) {
    S sum = r(i) * w.scale(i);
    for (int k = 0; k < i; ++k) sum -= w.L(i, k) * (*out)(k);
    (*out)(i) = sum / w.L(i, i);
  }
  return true;
}

/// Whitens residual and Jacobian rows in place.
template <class S>
bool whiten(const ImuIntegral<S>& I, const ImuNoise<S>& noise, ImuRows<S>* rows) {
  LinkWhitening<S> w;
  if (!link_whitening(I, noise, &w)) return false;
  for (int i = 0; i < 15; ++i) {
    S r = rows->r(i) * w.scale(i);
    rows->J.row(i) *= w.scale(i);
    for (int k = 0; k < i; ++k) {
      if (w.L(i, k) == S(0)) continue;
      r -= w.L(i, k) * rows->r(k);
      rows->J.row(i) -= w.L(i, k) * rows->J.row(k);
    }
    rows->r(i) = r / w.L(i, i);
    rows->J.row(i) /= w.L(i, i);
  }
  return true;
}

}  // namespace SEGCAL_NS
