// The IMU link between two keyframes: its 15 residuals, their Jacobians and their whitening (paper, Sec. IV-C).
#pragma once

#include "math/small_solvers.h"
#include "sensors/imu_integral.h"

namespace SEGCAL_NS {

/// Residual of a link, whitened, with Jacobians; paper, Sec. IV-C. Rows: rotation, velocity, position, b_a, b_g.
/// J: [state0 15 | state1 15 | imu theta 15].
template <class S>
struct ImuRows {
  Vec<S, 15> r;
  Eigen::Matrix<S, 15, 2 * kStateColumns + kImuColumns, Eigen::RowMajor> J;
};

/// Covariance of the link's 15 residuals: P with the walk of both biases over dt.
template <class S>
void link_covariance(const ImuIntegral<S>& I, const ImuNoise<S>& noise, Mat<S, 15, 15>* covariance) {
  Mat<S, 15, 15>& Q = *covariance;
  Q.setZero();
  Q.template topLeftCorner<9, 9>() = I.P;
  // Residual and P_b are both "truth minus integral": a bias that has grown by b1 - b0 makes the integral too large.
  Q.template topRightCorner<9, 6>() = I.P_b;
  Q.template bottomLeftCorner<6, 9>() = I.P_b.transpose();
  for (int i = 0; i < 3; ++i) {
    Q(9 + i, 9 + i) = noise.accel_walk * noise.accel_walk * I.dt;
    Q(12 + i, 12 + i) = noise.gyro_walk * noise.gyro_walk * I.dt;
  }
}

/// Residual r = (Log(dR' R0' R1), R0'(v1 - v0 - g dt) - dv,
/// R0'(p1 - p0 - v0 dt - g dt^2/2) - dp, b1 - b0), not whitened.
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

/// Fills residual and Jacobians, not whitened. `j0`, `j1` are the states at which the Jacobian is taken (the same as
/// x0, x1 except in a filter that keeps first estimates).
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

/// Adds `weight` |u| times the residual's part along u, in three rows from `row` on, to a column.
template <class S>
void add_along(const Vec3<S>& u, S weight, int row, int column, ImuRows<S>* rows) {
  const S length = square_root(u.squaredNorm());
  if (!(length > S(0))) return;
  const S part = weight / length * u.dot(rows->r.template segment<3>(row));
  for (int i = 0; i < 3; ++i) rows->J(row + i, column) += part * u(i);
}

/// Takes the readings' noise out of the columns by their scales, before whitening. A column by scale s of axis k, dr /
/// ds, holds the same noise as r, so that E[J' P^-1 r] is not zero at the truth but -tr(P_k P^-1) / s, P_k being what
/// axis k's white noise has of P: about two for each link and axis of the accelerometer. A fit of such rows ends where
/// the scale makes noise small, sigmas off where an IMU is rough. r' P(s)^-1 r is the likelihood of the readings (P is
/// of scaled noise), and its derivative has dr / ds + P_k P^-1 r / s, the column without its noise. White noise of the
/// accelerometer is nearly all of P's velocity and position, alike in all directions: P_k P^-1 r is r along the axis,
/// times that share.
template <class S>
void take_noise_off_scales(const ImuIntegral<S>& I, ImuRows<S>* rows) {
  constexpr int th = 2 * kStateColumns;
  const S along = I.P(3, 3) + I.P(4, 4) + I.P(5, 5);
  if (!(along > S(0))) return;
  const S share = S(3) * I.accel_density2 / along;  // over dt
  for (int k = 0; k < 3; ++k) {
    // By the bias: minus dt / s times the axis as it was on average.
    const Vec3<S> rate = I.J_R.col(kInputBg + k), force = I.J_v.col(kInputBa + k);
    add_along<S>(rate, S(1) / I.dt, 0, th + k, rows);
    add_along<S>(force, share, 3, th + 6 + k, rows);
    add_along<S>(force, share, 6, th + 6 + k, rows);
  }
}

/// The same columns for terms, after link_rows(): the rotation's at its residual, not whitened.
template <class S>
void link_term_columns(const ImuRows<S>& rows, ImuTermColumns<S>* columns) {
  const Mat3<S> Jt = so3_right_jacobian_inverse<S>(Vec3<S>(-rows.r.template head<3>()));
  for (int t = 0; t < columns->count(); ++t) {
    const Vec3<S> r = -(Jt * columns->J_R[t]);
    for (int i = 0; i < 3; ++i) {
      columns->link[t][i] = r(i);
      columns->link[t][3 + i] = -columns->J_v[t](i);
      columns->link[t][6 + i] = -columns->J_p[t](i);
    }
    for (int i = 9; i < 15; ++i) columns->link[t][i] = S(0);
  }
}

/// Square root of the link's information: a scale per row and a lower triangle, so that whitened = L^-1 (scale r).
/// Above its diagonal L holds what is left of the covariance.
template <class S>
struct LinkWhitening {
  Vec<S, 15> scale;
  Mat<S, 15, 15> L;
};

/// False if the covariance is not positive (a link of no duration). Scaled to unit diagonal first: the entries span ten
/// decades, and float keeps seven digits of each ratio.
template <class S>
bool link_whitening(const ImuIntegral<S>& I, const ImuNoise<S>& noise, LinkWhitening<S>* w) {
  Mat<S, 15, 15>& Q = w->L;
  link_covariance(I, noise, &Q);
  for (int i = 0; i < 15; ++i) {
    if (!(Q(i, i) > S(0))) return false;
    w->scale(i) = S(1) / square_root(Q(i, i));
  }
  for (int j = 0; j < 15; ++j) {
    for (int i = 0; i < 15; ++i) Q(i, j) = (Q(i, j) * w->scale(i)) * w->scale(j);
  }
  return cholesky_in_place<S, 15>(&Q);
}

/// A column of 15 rows, in place.
template <class S>
void whiten_column(const LinkWhitening<S>& w, S* x) {
  for (int i = 0; i < 15; ++i) x[i] *= w.scale(i);
  forward_substitute<S, 15>(w.L, x);
}

/// Whitens the residual alone.
template <class S>
bool whiten_residual(const ImuIntegral<S>& I, const ImuNoise<S>& noise, const Vec<S, 15>& r, Vec<S, 15>* out) {
  LinkWhitening<S> w;
  if (!link_whitening(I, noise, &w)) return false;
  *out = r;
  whiten_column(w, out->data());
  return true;
}

/// Whitens residual and Jacobian rows in place, and the columns of terms, if there are any.
template <class S>
bool whiten(const ImuIntegral<S>& I, const ImuNoise<S>& noise, ImuRows<S>* rows, ImuTermColumns<S>* columns = nullptr) {
  LinkWhitening<S> w;
  if (!link_whitening(I, noise, &w)) return false;
  for (int t = 0; columns && t < columns->count(); ++t) whiten_column(w, columns->link[t]);
  whiten_column(w, rows->r.data());
  for (int i = 0; i < 15; ++i) {
    rows->J.row(i) *= w.scale(i);
    for (int k = 0; k < i; ++k) {
      if (w.L(i, k) != S(0)) rows->J.row(i) -= w.L(i, k) * rows->J.row(k);
    }
    rows->J.row(i) /= w.L(i, i);
  }
  return true;
}

}  // namespace SEGCAL_NS
