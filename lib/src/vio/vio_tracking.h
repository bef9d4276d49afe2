// Vio: frames while the filter runs, and when it is lost.
#pragma once

#include "vio/vio.h"

namespace SEGCAL_NS {

template <class S>
VioStatus Vio<S>::track(std::int64_t t_ns, const TrackPoint<S>* points, int n, const ImuHistory<S>& imu) {
  const StillTest<S> test{options_, window_, tracks_, imu};
  still_ = test.still(t_ns, still_, points, n);
  const int spent = link_work(imu.at_or_before(t_ns) - imu.at_or_before(time_));
  const ImuIntegral<S> I = integral_between(window_, options_, imu, window_.now, time_, t_ns);
  if (still_) still_ = propagate_still(&window_, options_, I, test.shaking(t_ns));
  if (still_) {
    ++statistics_.standstill_frames;
    last_update_ = t_ns;
    denied_rest_ = 0;
    statistics_.dropped_points += tracks_.keep_alive(window_.newest().slot, points, n);
    use_ended_tracks(&window_, &tracks_, options_, &monitor_, &statistics_, spent);
  } else {
    denied_rest_ = test.rests(t_ns, points, n) ? denied_rest_ + 1 : 0;
    const Mat3<S> R_GI = window_.now.R_GI * I.dR;
    move_on(t_ns, points, n, I, test.place_kept(R_GI, monitor_.nearness, place_kept_, points, n), spent);
  }
  time_ = arrived_ = t_ns;
  window_.newest().time = t_ns;
  return healthy() ? VioStatus::tracking : give_up();
}

/// A new pose enters the window, features are used, the oldest pose leaves. `place`: the pose whose place it has not
/// left, or -1. `spent`: of the frame's work, by integrating.
template <class S>
void Vio<S>::move_on(std::int64_t t_ns, const TrackPoint<S>* points, int n, const ImuIntegral<S>& I, int place,
                     int spent) {
  const int slot = propagate(&window_, options_, I, t_ns);
  const bool held = place >= 0 && hold_place(&window_, place, options_.still_metres);
  monitor_.rho_sigma = held ? kHeldDepthSigma<S> : kFilterDepthSigma<S>;
  place_kept_ = held ? window_.n_poses - 3 - place : 0;
  statistics_.dropped_points += tracks_.observe(slot, points, n);
  const bool full = window_.n_poses == kWindow;
  const int used = full ? use_leaving_tracks(&window_, &tracks_, options_, &monitor_, &statistics_, spent)
                        : use_ended_tracks(&window_, &tracks_, options_, &monitor_, &statistics_, spent);
  if (used > 0) last_update_ = t_ns;
  if (full) make_room();
}

template <class S>
void Vio<S>::make_room() {
  tracks_.forget_slot(window_.pose[0].slot);
  drop_oldest(&window_);
}

/// Never diverge silently: what cannot be a device in someone's hand or on a robot is a lost filter.
template <class S>
bool Vio<S>::healthy() const {
  const State<S>& x = window_.now;
  const S speed2 = x.v_GI.squaredNorm(), place2 = x.p_GI.squaredNorm();
  if (!is_finite(speed2) || !is_finite(place2) || !is_finite(x.R_GI.sum())) return false;
  if (speed2 > options_.max_speed * options_.max_speed) return false;
  if (x.b_g.squaredNorm() > S(1) || x.b_a.squaredNorm() > S(9)) return false;
  if (S(time_ - last_update_) * S(1e-9) > options_.max_blind_s) return false;
  return denied_rest_ < kDeniedRest && !monitor_.failing();
}

template <class S>
[[gnu::cold]] VioStatus Vio<S>::give_up() {
  ++statistics_.restarts;
  origin_.remember(window_.now);
  window_.restore_calibration();
  forget();
  return VioStatus::lost;
}

}  // namespace SEGCAL_NS
