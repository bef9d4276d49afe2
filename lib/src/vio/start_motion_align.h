// First part of the start in motion (start_motion.h): the inertial integrals over the window, the
// gyroscope's bias from pairs of images, velocity and attitude by linear alignment.
#pragma once

#include "vio/start_motion.h"

namespace SEGCAL_NS {

/// Integrates once over the whole window at x0's biases and keeps the integral at each frame.
template <class S>
bool MotionStart<S>::integrate_step(const StartContext<S>& c, const Samples& imu) {
  SEGCAL_SLICES(leaf_) {
    base_ = c.s->x0;
    new_integrator(c.w)->begin(c.w->theta.imu, base_.b_a, base_.b_g, c.options.noise);
    t_ = c.w->pose[0].time;
    integrator_->start(reading_at<S>(imu, t_));
    copy_link(integrator_->result(), &c.s->link[0]);
    for (i_ = 1; i_ < c.w->n_poses; ++i_) {
      while (t_ < c.w->pose[i_].time) {
        integrate_some(imu, c.w->pose[i_].time);
        SEGCAL_PAUSE(leaf_);
      }
      copy_link(integrator_->result(), &c.s->link[i_]);
    }
  }
  SEGCAL_SLICES_END(leaf_);
}

template <class S>
void MotionStart<S>::integrate_some(const Samples& imu, std::int64_t end) {
  int k = imu.at_or_before(t_) + 1;
  for (int left = kSamplesPerSlice; left > 0; --left, ++k) {
    const bool between = k < imu.size() && imu.time(k) < end;
    const std::int64_t to = between ? imu.time(k) : end;
    integrator_->step(between ? imu.reading(k) : reading_at<S>(imu, end), S(to - t_) * S(1e-9));
    t_ = to;
    if (!between) return;
  }
}

/// Improves x0's gyroscope bias; the links follow it to first order, and are integrated anew at the end.
template <class S>
bool MotionStart<S>::gyro_bias_step(const StartContext<S>& c, const Samples& imu) {
  PackedTriangle<S> total(equations_, 4);
  SEGCAL_SLICES(inner_) {
    SEGCAL_AWAIT(inner_, integrate_step(c, imu));
    for (iteration_ = 0; iteration_ < 4; ++iteration_) {
      begin_gyro_bias(c.options, *c.s, &total);
      for (camera_ = 0; camera_ < c.w->theta.n_cameras; ++camera_) {
        for (k_ = 0; k_ + 2 < c.w->n_poses; ++k_) {
          fold_pair(*c.w, *c.tracks, *c.s, camera_, k_, k_ + 2,
                    S(1.5) * c.options.pixel_sigma / c.w->theta.camera[camera_].intrinsics(0), &total);
          SEGCAL_PAUSE(inner_);
        }
      }
      solve_gyro_bias(total, c.s);
      correct(c);
    }
    SEGCAL_AWAIT(inner_, integrate_step(c, imu));
  }
  SEGCAL_SLICES_END(inner_);
}

/// Velocity and attitude of x0 from the tracks; good_ is false if there are too few of them.
template <class S>
bool MotionStart<S>::align_step(const StartContext<S>& c) {
  const S magnitude = square_root(c.options.g.squaredNorm());
  PackedTriangle<S> R(equations_, 7);
  SEGCAL_SLICES(inner_) {
    g_ = mean_gravity(*c.w, *c.s, magnitude);
    v0_ = Vec3<S>::Zero();
    good_ = true;
    for (iteration_ = 0; iteration_ < 5 && good_; ++iteration_) {
      R.clear();
      used_ = 0;
      for (k_ = 0; k_ < c.tracks->end(); ++k_) {
        if (!(*c.tracks)[k_].used) continue;
        used_ += fold_alignment_track(c.w, *c.s, (*c.tracks)[k_], iteration_ > 0, v0_, g_,
                                      alignment_sigma(*c.w, c.options), &R)
                     ? 1
                     : 0;
        SEGCAL_PAUSE(inner_);
      }
      good_ = used_ >= 6 && solve_alignment(R, magnitude, &v0_, &g_);
    }
    if (good_) {
      c.s->x0.R_GI = c.origin.attitude(g_, c.options.g);
      c.s->x0.v_GI = c.s->x0.R_GI * v0_;
      c.s->x0.p_GI = c.origin.p_GI;
    }
  }
  SEGCAL_SLICES_END(inner_);
}

}  // namespace SEGCAL_NS
