// The fixed-size database of segments: a ring of N + 1 slots, one of them being built (paper, Sec. V-C).
// It keeps the set with the smallest sum of the metric: since the sum is over independent terms, that is the N
// smallest. `set_d` judges the set as a whole instead: of the N kept segments and a new one, the one leaves without
// which the others know most together, by log det of the prior's and their information. That is the best of all
// exchanges of one segment; it may miss an exchange of two.
#pragma once

#include "information/joint_information.h"
#include "segments/segment.h"

namespace SEGCAL_NS {

enum class Metric : std::int32_t { A = 0, D = 1, E = 2, random = 3, set_d = 4 };
enum class Strategy : std::int32_t {
  single_session = 0,  ///< each session starts empty
  multi_session = 1    ///< the best of all sessions stay
};

/// splitmix64 (Steele, Lea and Flood 2014): the random baseline must be the same on every machine.
inline std::uint64_t next_random(std::uint64_t* state) {
  std::uint64_t z = (*state += 0x9E3779B97F4A7C15ull);
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ull;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBull;
  return z ^ (z >> 31);
}

template <class S>
struct StoredFields;  // store/stored_fields.h

template <class S>
class Database {
  friend struct StoredFields<S>;

 public:
  static constexpr int kSlots = SEGCAL_MAX_SEGMENTS + 1;
  [[gnu::cold]] Database() = default;

  /// `capacity`: segments to keep, 1..SEGCAL_MAX_SEGMENTS.
  /// `least_gain`: nats below which a segment is not worth a slot.
  void reset(int capacity, Metric metric, Strategy strategy, S least_gain, std::uint64_t seed) {
    capacity_ = capacity;
    metric_ = metric;
    strategy_ = strategy;
    least_gain_ = least_gain;
    random_ = seed;
    offered_ = 0;
    for (bool& k : kept_) k = false;
    for (bool& o : outdated_) o = false;
    building_ = 0;
  }

  void begin_session() {
    if (strategy_ != Strategy::single_session) return;
    for (bool& k : kept_) k = false;
    for (bool& o : outdated_) o = false;
    offered_ = 0;
  }

  Segment<S>& building() { return slot_[building_]; }
  Segment<S>& slot(int i) { return slot_[i]; }
  const Segment<S>& slot(int i) const { return slot_[i]; }
  bool kept(int i) const { return kept_[i]; }
  int size() const {
    int n = 0;
    for (bool k : kept_) n += k ? 1 : 0;
    return n;
  }
  void drop(int i) { kept_[i] = false; }
  /// Drops a segment that newer ones contradict. It can be read until its slot is needed.
  void drop_outdated(const Segment<S>* segment) {
    const int i = static_cast<int>(segment - slot_);
    kept_[i] = false;
    outdated_[i] = true;
  }
  bool outdated(int i) const { return outdated_[i]; }
  int capacity() const { return capacity_; }
  bool full() const { return size() == capacity_; }

  /// Offers the scored segment in the building slot. True if it is kept; the next building slot is free then. `joint`
  /// does the sums of set_d; without it a full database stays as it is.
  bool offer(JointInformation<S>* joint = nullptr) {
    while (joint && !compare_step(joint)) {
    }
    return offer_compared(joint);
  }
  /// The sums of set_d in slices; offer_compared() needs them.
  bool compare_step(JointInformation<S>* joint) {
    if (metric_ != Metric::set_d || !full() || !worth_a_slot()) return true;
    const SegmentInformation<S>* information[kSlots];
    int slot[kSlots];
    return joint->gains_without_one_step(information, compared(information, slot));
  }
  [[gnu::cold]] bool offer_compared(JointInformation<S>* joint) {
    if (!worth_a_slot()) return false;
    const Segment<S>& segment = slot_[building_];
    ++offered_;
    if (full()) {
      const int victim = metric_ == Metric::random  ? random_victim()
                         : metric_ == Metric::set_d ? least_missed(joint)
                                                    : worse_than(value(segment));
      if (victim < 0) return false;
      kept_[victim] = false;
    }
    kept_[building_] = true;
    for (building_ = 0; kept_[building_]; ++building_) {
    }
    outdated_[building_] = false;
    return true;
  }

  /// Kept slots in order of session and time; returns their number. `Pointer`: to a Segment<S>.
  template <class Pointer>
  int in_order(Pointer* out) {
    int n = 0;
    for (int i = 0; i < kSlots; ++i) {
      if (!kept_[i]) continue;
      int at = n++;
      while (at > 0 && slot_[i].serial < out[at - 1]->serial) {
        out[at] = out[at - 1];
        --at;
      }
      out[at] = &slot_[i];
    }
    return n;
  }

 private:
  S value(const Segment<S>& s) const {
    return metric_ == Metric::A ? s.metrics.A : metric_ == Metric::D ? s.metrics.D : s.metrics.E;
  }
  /// The kept segment with the largest value above `limit`; -1 if there is none.
  int worse_than(S limit) const {
    int worst = -1;
    for (int i = 0; i < kSlots; ++i) {
      if (kept_[i] && value(slot_[i]) > (worst < 0 ? limit : value(slot_[worst]))) worst = i;
    }
    return worst;
  }
  bool worth_a_slot() const {
    const Metrics<S>& metrics = slot_[building_].metrics;
    return is_finite(metrics.A) && !(metrics.gain < least_gain_);
  }
  /// The kept segments and the new one, and their slots; returns their number.
  int compared(const SegmentInformation<S>** information, int* slot) const {
    int n = 0;
    for (int i = 0; i < kSlots; ++i) {
      if (!kept_[i] && i != building_) continue;
      information[n] = &slot_[i].information;
      slot[n++] = i;
    }
    return n;
  }
  /// The kept segment without which the others and the new one know most together; -1 if that is the new one itself.
  int least_missed(const JointInformation<S>* joint) const {
    if (!joint) return -1;
    const SegmentInformation<S>* information[kSlots];
    int slot[kSlots], victim = -1;
    const int n = compared(information, slot);
    S most = S(0);
    for (int i = 0; i < n; ++i) {
      if (slot[i] == building_) most = joint->gain_without(i);
    }
    for (int i = 0; i < n; ++i) {
      if (slot[i] == building_ || !(joint->gain_without(i) > most)) continue;
      victim = slot[i];
      most = joint->gain_without(i);
    }
    return victim;
  }
  /// Reservoir sampling: each segment of the stream stays with the same probability.
  int random_victim() {
    const std::uint64_t draw = next_random(&random_) % offered_;
    if (draw >= static_cast<std::uint64_t>(capacity_)) return -1;
    int nth = static_cast<int>(draw);
    for (int i = 0; i < kSlots; ++i) {
      if (kept_[i] && nth-- == 0) return i;
    }
    return -1;
  }

  Segment<S> slot_[kSlots];
  bool kept_[kSlots], outdated_[kSlots];
  std::int32_t building_, capacity_;
  Metric metric_;
  Strategy strategy_;
  S least_gain_;
  std::uint64_t random_, offered_;
};

}  // namespace SEGCAL_NS
