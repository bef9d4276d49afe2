// When the device became another one: steps between what was known and a release that dropped it.
//
// A segment that contradicts what is known (contradiction.h) opens a change and says when. The next calibration closes
// it: a change if all that it dropped, taken together, contradicts what it kept (agreement.h).
#pragma once

#include "sensors/calibration.h"

namespace SEGCAL_NS {

/// As many as epochs; a build without any keeps none.
constexpr int kChanges = SEGCAL_MAX_EPOCHS > 0 ? SEGCAL_MAX_EPOCHS : 1;
/// Probability that a calibration after a false alarm (kFalseAlarm), which also dropped something, finds a change.
constexpr double kFalseChange = 1e-4;

template <class S>
struct Change {
  std::uint32_t before_session = 0, after_session = 0;  ///< of the segments on both sides
  std::int64_t t_ns = 0;                                ///< first keyframe of the segment that did not fit
  std::int32_t n = 0;
  /// Of theta's columns; while it is open: no step, and sigmas of what was known.
  S step[kMaxTheta] = {}, sigma[kMaxTheta] = {};
};

template <class S>
struct StoredFields;  // store/stored_fields.h

/// The newest ones, newest first.
template <class S>
class Changes {
  friend struct StoredFields<S>;

 public:
  void clear() {
    count_ = 0;
    close();
  }
  int count() const { return count_; }
  const Change<S>* find(int i) const { return i >= 0 && i < count_ ? &change_[i] : nullptr; }
  const Change<S>* open() const { return is_open_ ? &open_ : nullptr; }
  void close() { is_open_ = false; }

  /// An earlier one that is still open began it all. `sigma`: of what was known.
  void open(std::uint32_t before_session, std::uint32_t after_session, std::int64_t t_ns, const S* sigma, int n) {
    if (is_open_) return;
    is_open_ = true;
    open_.before_session = before_session;
    open_.after_session = after_session;
    open_.t_ns = t_ns;
    open_.n = n;
    for (int i = 0; i < n; ++i) {
      open_.step[i] = S(0);
      open_.sigma[i] = sigma[i];
    }
  }

  /// At a release that found one: from `before` to `after`, with its sigmas.
  void decide(const Calibration<S>& before, const Calibration<S>& after, const S* sigma) {
    if (!is_open_) return;
    is_open_ = false;
    difference(before, after, open_.step);
    for (int i = 0; i < open_.n; ++i)
      open_.sigma[i] = square_root(open_.sigma[i] * open_.sigma[i] + sigma[i] * sigma[i]);
    push();
  }

 private:
  void push() {
    count_ = count_ < kChanges ? count_ + 1 : count_;
    for (int i = count_ - 1; i > 0; --i) change_[i] = change_[i - 1];
    change_[0] = open_;
  }

  std::int32_t count_ = 0;
  Change<S> change_[kChanges], open_;
  bool is_open_ = false;
};

/// Of a build without epochs.
template <class S>
struct NoChanges {
  void clear() {}
  void close() {}
  const Change<S>* find(int) const { return nullptr; }
  const Change<S>* open() const { return nullptr; }
};

}  // namespace SEGCAL_NS
