// Feature tracks over the poses of the window: who was seen where, and which tracks are due.
#pragma once

#include "vio/vio_window.h"

namespace SEGCAL_NS {

constexpr int kMaxVioTracks = SEGCAL_MAX_TRACKS * kMaxCameras;
static_assert(kWindow <= 32, "a track's slots are bits of one word");

template <class S>
struct VioTrack {
  std::uint32_t id;
  std::uint32_t slots;  ///< bit s: uv[s] is there
  std::int16_t camera;
  bool used;            ///< entry of the table is taken
  bool alive;           ///< seen in the newest frame
  Vec2<S> uv[kWindow];  ///< px, by slot

  bool in(int slot) const { return slots >> slot & 1u; }
  int length() const {
    int n = 0;
    for (std::uint32_t s = slots; s; s &= s - 1) ++n;
    return n;
  }
};

template <class S>
class TrackTable {
 public:
  void clear(int n_cameras) {
    for (int i = 0; i < kMaxVioTracks; ++i) track_[i].used = false;
    end_ = 0;
    n_cameras_ = n_cameras;
  }
  /// Entries [0, end()) may be used.
  int end() const { return end_; }
  VioTrack<S>& operator[](int i) { return track_[i]; }
  const VioTrack<S>& operator[](int i) const { return track_[i]; }

  /// Image points of a new pose. Returns how many found no room.
  int observe(int slot, const TrackPoint<S>* points, int n) {
    return enter(points, n, [slot](VioTrack<S>* track, const Vec2<S>& uv) {
      track->uv[slot] = uv;
      track->slots |= 1u << slot;
    });
  }

  /// Image points of a frame in which the newest pose (at `slot`) has not moved: only new tracks are entered.
  int keep_alive(int slot, const TrackPoint<S>* points, int n) {
    return enter(points, n, [slot](VioTrack<S>* track, const Vec2<S>& uv) {
      if (track->slots) return;
      track->uv[slot] = uv;
      track->slots = 1u << slot;
    });
  }

  /// The pose of `slot` leaves the window.
  void forget_slot(int slot) {
    for (int i = 0; i < end_; ++i) track_[i].slots &= ~(1u << slot);
  }

  void remove_ended_shorter_than(int length) {
    for (int i = 0; i < end_; ++i) {
      VioTrack<S>& track = track_[i];
      if (track.used && !track.alive && track.length() < length) track.used = false;
    }
  }

  const VioTrack<S>* find(std::uint32_t id, int camera) const {
    for (int i = 0; i < end_; ++i) {
      if (track_[i].used && track_[i].id == id && track_[i].camera == camera) return &track_[i];
    }
    return nullptr;
  }

 private:
  template <class Put>
  int enter(const TrackPoint<S>* points, int n, Put put) {
    int refused = 0;
    for (int i = 0; i < end_; ++i) track_[i].alive = false;
    for (int i = 0; i < n; ++i) {
      const TrackPoint<S>& point = points[i];
      if (point.camera < 0 || point.camera >= n_cameras_ || !is_finite(point.uv.sum())) continue;
      VioTrack<S>* track = find_or_create(point);
      if (!track) {
        ++refused;
        continue;
      }
      track->alive = true;
      put(track, point.uv);
    }
    return refused;
  }

  VioTrack<S>* find_or_create(const TrackPoint<S>& point) {
    const VioTrack<S>* known = find(point.id, point.camera);
    if (known && known->alive) return nullptr;  // the same id twice in one frame
    if (known) return const_cast<VioTrack<S>*>(known);
    int free = 0;
    while (free < end_ && track_[free].used) ++free;
    if (free == kMaxVioTracks) return nullptr;
    if (free == end_) ++end_;
    track_[free].id = point.id;
    track_[free].slots = 0;
    track_[free].camera = static_cast<std::int16_t>(point.camera);
    track_[free].used = true;
    track_[free].alive = false;
    return &track_[free];
  }

  VioTrack<S> track_[kMaxVioTracks];
  int end_, n_cameras_;
};

}  // namespace SEGCAL_NS
