// ImuIntegrator: the covariance of the integral, from white noise and from the walk of the biases over the link.
#pragma once

#include "sensors/imu_integral.h"

namespace SEGCAL_NS {

/// P <- F P F' + Q with F = [Et 0 0; Fv I 0; Fp dt I], and the bias walk carried along in P_b. P is symmetric and only
/// its blocks on and above the diagonal are kept; complete() makes the others. In place, one row of F after the other,
/// the last first: it needs the old ones above.
template <class S>
void ImuIntegrator<S>::propagate_noise(const Mat3<S>& Et, const Mat3<S>& Jr, const Mat3<S>& V0, const Mat3<S>& V1,
                                       const Mat3<S>& RB, S dt) {
  const Mat3<S> V1Et = product(V1, Et);
  const Mat3<S> Fv = -(dt / S(2)) * (V0 + V1Et);
  const Mat3<S> Fp = -(dt * dt / S(3)) * V0 - (dt * dt / S(6)) * V1Et;
  const Block3<S> RR = P(0, 0), RV = P(0, 1), RP = P(0, 2), VV = P(1, 1), VP = P(1, 2), PP = P(2, 2),
                  Fpt = Block3<S>(Fp).transpose(), Fvt = Block3<S>(Fv).transpose();
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

/// What the step's own noise adds, and the walk of the biases: after t seconds it has variance sigma^2 t. A bias moves
/// the rotation by G_R (b_g), the velocity by G_v and the position by dt / 2 G_v (b_a); no rotation follows from b_a.
template <class S>
void ImuIntegrator<S>::add_walk(const Mat3<S>& Jr, const Mat3<S>& RB, S dt) {
  const Mat3<S> G_R = -dt * product(Jr, T_g_inv_), G_v = -dt * RB;
  const Block3<S> G_Rt = Block3<S>(G_R).transpose(), G_vt = Block3<S>(G_v).transpose();
  const S va = noise_.accel_walk * noise_.accel_walk * I_.dt, vg = noise_.gyro_walk * noise_.gyro_walk * I_.dt,
          half = dt / S(2);
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
