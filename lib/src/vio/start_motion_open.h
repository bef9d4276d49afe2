// Last part of the start in motion (start_motion.h): prior, links and features of the filter's window.
#pragma once

#include "vio/start_motion.h"
#include "vio/window_update.h"

namespace SEGCAL_NS {

/// The prior of the first state, then its information through the window
/// by the inertial links. good_ is false if a link has no duration.
template <class S>
bool MotionStart<S>::open_step(const StartContext<S>& c, const Samples& imu) {
  SEGCAL_SLICES(inner_) {
    begin_window(c.w, c.options, c.s->x0, S(3));
    SEGCAL_PAUSE(inner_);
    for (i_ = 1; i_ < c.w->n_poses && good_; ++i_) {
      new_integrator(c.w)->begin(c.w->theta.imu, c.w->now.b_a, c.w->now.b_g,
                                 noise_in(imu, c.options.noise, c.w->pose[i_ - 1].time, c.w->pose[i_].time, S(1e-9)),
                                 &c.w->theta.effects);
      samples_.restart();
      SEGCAL_AWAIT(inner_, samples_.step(imu, c.w->pose[i_ - 1].time, c.w->pose[i_].time, S(1e-9), integrator_,
                                         stretch_between(c.w->pose[i_ - 1].time, c.w->pose[i_].time, imu.warmth,
                                                         c.w->now.R_GI, *integrator_)));
      SEGCAL_PAUSE(inner_);
      good_ = link_poses(c);
      for (row_ = 0; good_ && row_ < kLinkRows; row_ += rows_) {
        SEGCAL_PAUSE(inner_);
        rows_ = reduce_link(c.w, row_, i_ - 1, i_);
        SEGCAL_PAUSE(inner_);
        for (column_ = 0; !fold_some(c.w, link_rows_in(c.w), rows_);) SEGCAL_PAUSE(inner_);
      }
    }
  }
  SEGCAL_SLICES_END(inner_);
}

/// Linearises link i_; the old motion goes into the block, and the link's second pose is placed.
template <class S>
bool MotionStart<S>::link_poses(const StartContext<S>& c) {
  Window<S>* w = c.w;
  const ImuIntegral<S>& I = integrator_->result();
  const State<S> x1 = predicted(I, w->now, c.options.g);
  if (!linearise_link(w, c.options, I, x1, x1)) return false;
  w->link().r.setZero();
  stack_motion(w);
  w->pose[i_].R_GI = w->pose[i_].R_first = x1.R_GI;
  w->pose[i_].p_GI = w->pose[i_].p_first = x1.p_GI;
  w->now = w->now_first = x1;
  return true;
}

/// All features, when the window is all there is, and the update.
template <class S>
bool MotionStart<S>::use_tracks_step(const StartContext<S>& c) {
  Window<S>* w = c.w;
  SEGCAL_SLICES(inner_) {
    *c.monitor = ResidualMonitor<S>();
    c.monitor->scale = c.s->pixel_scale;
    used_ = 0;
    for (k_ = 0; k_ < c.tracks->end(); ++k_) {
      if (!(*c.tracks)[k_].used) continue;
      if ((*c.tracks)[k_].length() >= kMinTrackLength) {
        if (prepare_feature(w, (*c.tracks)[k_], c.options, c.monitor, c.statistics, &feature_)) {
          SEGCAL_PAUSE(inner_);
          for (column_ = feature_.first; !fold_some(w, feature_rest(w), feature_.dof);) SEGCAL_PAUSE(inner_);
          if (passes_gate(feature_, left_over(w, feature_rest(w), feature_.dof), c.monitor, c.statistics)) {
            ++used_;
          } else {
            SEGCAL_PAUSE(inner_);
            for (column_ = w->columns(); !unfold_some(w, feature_rest(w), feature_.dof, feature_.first);)
              SEGCAL_PAUSE(inner_);
          }
        }
        (*c.tracks)[k_].slots = 0;
        SEGCAL_PAUSE(inner_);
      }
      if (!(*c.tracks)[k_].alive) (*c.tracks)[k_].used = false;
    }
    if (used_ > 0) apply_update(w);
    SEGCAL_PAUSE(inner_);
    if (w->n_poses == kWindow) {
      c.tracks->forget_slot(w->pose[0].slot);
      drop_oldest(w);
    }
  }
  SEGCAL_SLICES_END(inner_);
}

/// Goes on with a fold of m rows from column_ on; true when it is done.
template <class S>
bool MotionStart<S>::fold_some(Window<S>* w, S* rows, int m) {
  const int n = w->columns();
  int until = column_;
  for (int work = 0; until < n && work < kFoldWork; ++until) work += m * (n + 1 - until);
  fold_columns(w, rows, m, column_, until);
  column_ = until;
  return until == n;
}

/// The same for taking one back, from column_ down to `first`.
template <class S>
bool MotionStart<S>::unfold_some(Window<S>* w, S* rows, int m, int first) {
  int from = column_;
  for (int work = 0; from > first && work < kFoldWork; --from) work += m * (w->columns() + 1 - from);
  unfold_columns(w, rows, m, from, column_);
  column_ = from;
  return from == first;
}

}  // namespace SEGCAL_NS
