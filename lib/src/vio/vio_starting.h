// Vio: frames that come before the filter runs, and how it begins: at rest at once, in motion when its slices are done.
#pragma once

#include "vio/vio.h"

namespace SEGCAL_NS {

/// So many samples, and a few, come in the time of the window's last two frames.
template <class S>
int samples_until_next_frame(const ImuHistory<S>& imu, const Window<S>& w) {
  const int n = imu.at_or_before(w.newest().time) - imu.at_or_before(w.pose[w.n_poses - 2].time);
  return n + n / 4 + 2;
}

template <class S>
void Vio<S>::forget_oldest_frame() {
  tracks_.forget_slot(window_.pose[0].slot);
  window_.forget_oldest();
}

/// Frames pile up in the window until gravity, velocity and biases can be told.
template <class S>
VioStatus Vio<S>::collect(std::int64_t t_ns, const TrackPoint<S>* points, int n, const ImuHistory<S>& imu) {
  if (!imu.covers(t_ns, t_ns)) return VioStatus::skipped;
  time_ = arrived_ = t_ns;
  while (window_.n_poses == kMostStartFrames || (window_.n_poses > 0 && !imu.covers(window_.pose[0].time, t_ns))) {
    forget_oldest_frame();
  }
  ++statistics_.frames_waited;
  const int slot = window_.append_empty(t_ns);
  statistics_.dropped_points += tracks_.observe(slot, points, n);
  tracks_.remove_ended_shorter_than(3);
  return try_to_start(t_ns, imu);
}

template <class S>
bool enough_frames(const Window<S>& w) {
  if (w.n_poses == kMostStartFrames) return true;
  return w.n_poses >= kStartFrames && double(w.newest().time - w.pose[0].time) * 1e-9 >= kShortestStart;
}

/// A start takes as long as a hundred frames, and what refused the last one is still in most of the window. The next
/// one is made when the time since the first has grown by a quarter, or sooner the less is missing: one that had 1 + x
/// times what it may have (`lack`) is followed by another x / 2 s later, half a second at most. Starts that are
/// background work have their delay between them.
template <class S>
bool too_soon_to_start(std::int64_t first_ns, std::int64_t last_ns, std::int64_t t_ns, S lack) {
  if (SEGCAL_START_DELAY_MS > 0) return false;
  const S growth = S(t_ns - first_ns) * S(0.25e-9), missing = S(0.5) * (lack - S(1));
  S wait = growth < S(0.5) ? growth : S(0.5);
  if (missing < wait) wait = missing;
  return S(t_ns - last_ns) * S(1e-9) < wait - S(1e-3);  // of grace, as for the frames' distance
}

template <class S>
[[gnu::cold]] VioStatus Vio<S>::try_to_start(std::int64_t t_ns, const ImuHistory<S>& imu) {
  start_.link = window_.begin_start_links();
  if (window_at_rest(window_, tracks_, options_, imu)) {
    start_at_rest(&window_, &tracks_, options_, origin_, imu, &start_);
    monitor_ = ResidualMonitor<S>();
    return begin_running();
  }
  if (!enough_frames(window_)) return VioStatus::initialising;
  if (statistics_.starts_tried > 0 && too_soon_to_start<S>(waiting_since_, start_due_, t_ns, start_.lack)) {
    ++statistics_.starts_tried;
    return VioStatus::initialising;
  }
  motion_.begin(window_, imu);
  start_due_ = t_ns + std::int64_t(SEGCAL_START_DELAY_MS) * 1000000;
  const bool in_background = start_due_ > t_ns;
  while (in_background && !motion_.keeps_samples(imu, samples_until_next_frame(imu, window_))) {
    motion_.cancel();  // the samples would be gone before there is time for it
    if (window_.n_poses <= kStartFrames) return VioStatus::initialising;
    forget_oldest_frame();
    motion_.begin(window_, imu);
  }
  if (statistics_.starts_tried++ == 0) waiting_since_ = t_ns;
  start_.waited = S(t_ns - waiting_since_) * S(1e-9);
  starting_ = true;
  if (in_background) return VioStatus::initialising;
  finish_start(imu);
  starting_ = false;
  return motion_.succeeded() ? begin_running() : VioStatus::initialising;
}

/// Frames between those of the start and its effect are let go: features are tracked over the gap. A start that is late
/// takes effect at a later frame, as long as its samples are there.
template <class S>
[[gnu::cold]] VioStatus Vio<S>::wait_for_start(std::int64_t t_ns, const TrackPoint<S>* points, int n,
                                               const ImuHistory<S>& imu) {
  arrived_ = t_ns;
  if (!motion_.keeps_samples(imu, 0)) {  // no frame came in time
    forget();
    return collect(t_ns, points, n, imu);
  }
  const bool last_chance = !motion_.keeps_samples(imu, samples_until_next_frame(imu, window_));
  // One millisecond of grace, as for the frames' distance.
  if (t_ns < start_due_ - 1000000 && !last_chance) return VioStatus::initialising;
  if (start_pending() && !options_.late_start_at_once) {
    ++statistics_.late_starts;
    if (!last_chance) return VioStatus::initialising;
    forget();
    return collect(t_ns, points, n, imu);
  }
  if (finish_start(imu)) ++statistics_.late_starts;
  starting_ = false;
  if (!motion_.succeeded()) {
    forget();  // what came meanwhile is missing between its frames and those to come
    return collect(t_ns, points, n, imu);
  }
  const VioStatus begun = begin_running();
  return begun == VioStatus::tracking ? track(t_ns, points, n, imu) : begun;
}

/// From the window as a start has left it.
template <class S>
VioStatus Vio<S>::begin_running() {
  running_ = true;
  still_ = start_.still;
  ++statistics_.starts;
  statistics_.frames_waited = statistics_.starts_tried = 0;
  last_update_ = time_;
  return healthy() ? VioStatus::tracking : give_up();
}

}  // namespace SEGCAL_NS
