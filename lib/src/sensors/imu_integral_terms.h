// ImuIntegrator: terms of effects are taken off the readings, and the integral's derivatives by their coefficients.
#pragma once

#include "sensors/imu_integral.h"

namespace SEGCAL_NS {

/// A term is a function of the true rate and force, and the reading has it on top: x = x_m - c phi(x), a fixed point
/// that each pass approaches by the factor c phi'. At worst, k = 0.017 s/rad at 3 rad/s or k = 6e-3 s^2/m at 10 m/s^2,
/// that is 0.1; two passes left 4 k^3 w^4 of the reading, which moved k by 3 %, seven of its sigmas.
constexpr int kTermPasses = 4;

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

}  // namespace SEGCAL_NS
