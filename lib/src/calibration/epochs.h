// The epochs of a device, in order of time.
#pragma once

#include "calibration/epoch.h"

namespace SEGCAL_NS {

constexpr int kEpochs = SEGCAL_MAX_EPOCHS;

template <class S>
struct StoredFields;  // store/stored_fields.h

/// The epochs of a device, oldest first. When there is no place for another, the two oldest become one.
template <class S>
class Epochs {
  friend struct StoredFields<S>;

 public:
  void clear() { count_ = 0; }
  int count() const { return count_; }
  const Epoch<S>& epoch(int i) const { return epoch_[i]; }
  /// Null if there is none.
  const Epoch<S>* find(int i) const { return i >= 0 && i < count_ ? &epoch_[i] : nullptr; }
  Epoch<S>& newest() { return epoch_[count_ - 1]; }
  int segments() const {
    int n = 0;
    for (int i = 0; i < count_; ++i) n += epoch_[i].segments;
    return n;
  }

  [[gnu::cold]] Epoch<S>& begin(const Calibration<S>& theta, std::uint32_t session) {
    if (count_ > 0 && newest().segments == 0) --count_;
    if (count_ == kEpochs) {
      epoch_[1].merge(epoch_[0]);
      drop(0);
    }
    epoch_[count_].begin(theta, session);
    return epoch_[count_++];
  }
  /// An empty one at its place in time, before those whose newest segment came after `serial`.
  [[gnu::cold]] Epoch<S>& insert(const Calibration<S>& theta, std::uint32_t session, std::uint32_t serial) {
    begin(theta, session);
    int i = count_ - 1;
    for (; i > 0 && epoch_[i - 1].last_serial > serial; --i) epoch_[i] = epoch_[i - 1];
    epoch_[i].begin(theta, session);
    return epoch_[i];
  }
  bool widen(int i, const Calibration<S>& at, const ThetaPrior<S>& prior, S* scratch) {
    return epoch_[i].widen_for(at, prior, scratch);
  }
  [[gnu::cold]] void drop(int i) {
    for (--count_; i < count_; ++i) epoch_[i] = epoch_[i + 1];
  }

  std::int32_t image_points() const {
    std::int32_t n = 0;
    for (int i = 0; i < count_; ++i) n += epoch_[i].image_points;
    return n;
  }

  S cost(const Calibration<S>& theta) const {
    S sum = S(0);
    for (int i = 0; i < count_; ++i) sum += epoch_[i].cost(theta);
    return sum;
  }
  S dof() const {
    S sum = S(0);
    for (int i = 0; i < count_; ++i) sum += epoch_[i].dof;
    return sum;
  }
  /// Folds row i of each epoch, 0 <= i <= n, into a triangle over [theta | rhs].
  [[gnu::cold]] void fold_into(const Calibration<S>& theta, PackedTriangle<S>* T) const {
    const int n = theta.columns();
    S offset[kMaxTheta];
    for (int e = 0; e < count_; ++e) {
      difference(epoch_[e].theta, theta, offset);
      fold_moved_rows(epoch_[e].information, offset, n + 1, T);
    }
  }

 private:
  std::int32_t count_ = 0;
  Epoch<S> epoch_[kEpochs > 0 ? kEpochs : 1];
};

/// Of a build without epochs.
template <class S>
struct NoEpochs {
  void clear() {}
  static constexpr int count() { return 0; }
  const Epoch<S>* find(int) const { return nullptr; }
};

}  // namespace SEGCAL_NS
