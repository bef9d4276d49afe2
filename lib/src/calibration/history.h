// What each session said about theta, for the question how theta changed: by steps, with time, or with temperature
// (course.h).
//
// Epochs are what a calibration is made from: they are merged, widened, and dropped where a change outdated them. Here
// all that was condensed stays, an entry a session, n (n + 3) / 2 numbers each, until newer ones need the place.
#pragma once

#include "calibration/moved_rows.h"

namespace SEGCAL_NS {

constexpr int kHistory = SEGCAL_MAX_HISTORY;

template <class S>
struct HistoryEntry {
  std::int32_t segments = 0;
  std::uint32_t session = 0;
  std::int32_t changes = 0;           ///< of the device that were decided before what it says
  S warmth = S(0);                    ///< sum over its segments, degC above 25
  Calibration<S> theta;               ///< theta_0
  SegmentInformation<S> information;  ///< over [theta | rhs]; its own dof is not used

  S mean_warmth() const { return segments > 0 ? warmth / S(segments) : S(0); }
};

template <class S>
struct StoredHistory;  // store/stored_history.h

/// In order of time, oldest first.
template <class S>
class History {
  friend struct StoredHistory<S>;

 public:
  void clear() { count_ = changes_ = 0; }
  int count() const { return count_; }
  const HistoryEntry<S>* find(int i) const { return i >= 0 && i < count_ ? &entry_[i] : nullptr; }
  /// Of the device, decided so far.
  int changes() const { return changes_; }

  /// Takes what a segment said: its rows, linearised at `at`. `warmth`: degC above 25.
  [[gnu::cold]] void add(const SegmentInformation<S>& rows, const Calibration<S>& at, std::uint32_t session, S warmth) {
    const int place = place_of(session, at);
    if (place < 0) return;
    HistoryEntry<S>& e = entry_[place];
    PackedTriangle<S> T = e.information.triangle();
    fold_moved(rows, at, e.theta, &T);
    e.warmth += warmth;
    ++e.segments;
  }
  /// The device became another one. What later sessions than `before_session` said is of the new one.
  void take_change(std::uint32_t before_session) {
    ++changes_;
    for (int i = 0; i < count_; ++i) {
      if (entry_[i].session > before_session) entry_[i].changes = changes_;
    }
  }

 private:
  /// An entry of this session since the last change; a new one, in order of time, if there is none. Below 0: it is
  /// older than all, and there is no place.
  int place_of(std::uint32_t session, const Calibration<S>& at) {
    int i = count_ - 1;
    for (; i >= 0 && entry_[i].session >= session; --i) {
      if (entry_[i].session > session) continue;
      if (entry_[i].changes == changes_) return i;
      break;  // what it said before the last change
    }
    if (count_ == kHistory) {
      if (i < 0) return -1;
      for (int k = 0; k < i; ++k) entry_[k] = entry_[k + 1];
      --i;
    } else {
      for (int k = count_++; k > i + 1; --k) entry_[k] = entry_[k - 1];
    }
    begin(&entry_[i + 1], session, at);
    return i + 1;
  }
  void begin(HistoryEntry<S>* e, std::uint32_t session, const Calibration<S>& at) {
    e->segments = 0;
    e->session = session;
    e->changes = changes_;
    e->warmth = S(0);
    e->theta = at;
    e->information.n_theta = at.columns();
    e->information.triangle().clear();
  }

  std::int32_t count_ = 0, changes_ = 0;
  HistoryEntry<S> entry_[kHistory > 0 ? kHistory : 1];
};

/// Of a build without one.
template <class S>
struct NoHistory {
  void clear() {}
  static constexpr int count() { return 0; }
  const HistoryEntry<S>* find(int) const { return nullptr; }
};

}  // namespace SEGCAL_NS
