// How far the gyroscope has turned, at nodes 5 ms apart, for as
// long as a search over half a second either way looks back.
//
// Offsets are tried in steps of the nodes, so that a moment has the same share of a
// step at each of them, and a trial reads four nodes. Angles are whole numbers of
// 2^-24 rad that wrap: differences are exact however long the device has turned.
#pragma once

#include <cstdint>

#include "clock/criteria.h"
#include "math/types.h"

namespace SEGCAL_NS {

constexpr std::int64_t kNodeNs = 5000000;  ///< clock_criteria::kStep_s
static_assert(1e-9 * kNodeNs > 0.999 * clock_criteria::kStep_s && 1e-9 * kNodeNs < 1.001 * clock_criteria::kStep_s,
              "offsets are tried in steps of the nodes");

/// A moment: the node at or before it, and the share of a step beyond.
template <class S>
struct NodePlace {
  std::int64_t node;
  S share;

  static NodePlace of(std::int64_t t_ns) {
    std::int64_t node = t_ns / kNodeNs, rest = t_ns % kNodeNs;
    if (rest < 0) {
      rest += kNodeNs;
      --node;
    }
    return {node, static_cast<S>(rest) / S(kNodeNs)};
  }
};

template <class S>
class GyroNodes {
 public:
  /// Half a second either way, the longest pair, and as long again
  /// for blocks of samples and for a background that is late: 1.9 s.
  static constexpr int kNodes = 384;
  /// Samples further apart are no path: what turned between them is not known.
  static constexpr std::int64_t kGapNs = 100000000;

  void reset() {
    count_ = 0;
    began_ = false;
  }
  /// The next sample, rad/s, at most some 100; stamps grow.
  void add(std::int64_t t_ns, const Vec3<S>& w) {
    if (began_ && t_ns - t_ns_ > kGapNs) reset();
    if (began_) {
      turn_to(t_ns, w);
    } else {
      newest_ = NodePlace<S>::of(t_ns).node;  // the first node is behind it
      began_ = true;
    }
    t_ns_ = t_ns;
    w_ = w;
  }

  /// All nodes from `first` to `last` are there; `gone`: some are no longer, or never will be.
  bool covers(std::int64_t first, std::int64_t last) const { return began_ && !gone(first) && last <= newest_; }
  bool gone(std::int64_t first) const { return began_ && first <= newest_ - count_; }

  /// Rotation from a to b as the sum of rates, rad; both and their next nodes are covered. Linear between nodes: the
  /// same error at each offset, and none that prefers a direction of time.
  Vec3<S> turned(const NodePlace<S>& a, const NodePlace<S>& b) const {
    const Angle &a0 = at(a.node), &a1 = at(a.node + 1), &b0 = at(b.node), &b1 = at(b.node + 1);
    Vec3<S> out;
    for (int i = 0; i < 3; ++i) {
      out(i) =
          kUnit * (difference(b0[i], a0[i]) + b.share * difference(b1[i], b0[i]) - a.share * difference(a1[i], a0[i]));
    }
    return out;
  }

 private:
  using Angle = std::uint32_t[3];
  static constexpr S kUnit = S(1) / S(1 << 24);

  static S difference(std::uint32_t later, std::uint32_t earlier) {
    return static_cast<S>(static_cast<std::int32_t>(later - earlier));
  }
  static std::uint32_t whole(S angle) {
    return static_cast<std::uint32_t>(static_cast<std::int32_t>(angle * S(1 << 24)));
  }

  const Angle& at(std::int64_t node) const {
    int slot = head_ - static_cast<int>(newest_ - node);
    if (slot < 0) slot += kNodes;
    return angle_[slot];
  }

  /// The rate is linear from sample to sample: after a share x
  /// of the step h it has turned by h x (w0 + x (w1 - w0) / 2).
  void turn_to(std::int64_t t_ns, const Vec3<S>& w) {
    const std::int64_t step_ns = t_ns - t_ns_;
    const S h = static_cast<S>(step_ns) * S(1e-9);
    while ((newest_ + 1) * kNodeNs <= t_ns) {
      ++newest_;
      head_ = head_ + 1 == kNodes ? 0 : head_ + 1;
      if (count_ < kNodes) ++count_;
      const S x = static_cast<S>(newest_ * kNodeNs - t_ns_) / static_cast<S>(step_ns);
      for (int i = 0; i < 3; ++i) angle_[head_][i] = now_[i] + whole(h * x * (w_(i) + S(0.5) * x * (w(i) - w_(i))));
    }
    for (int i = 0; i < 3; ++i) now_[i] += whole(h * S(0.5) * (w_(i) + w(i)));
  }

  std::int64_t t_ns_ = 0, newest_ = 0;  ///< of the last sample; number of the newest node: stamps over kNodeNs
  Vec3<S> w_ = Vec3<S>::Zero();
  Angle now_ = {0, 0, 0};  ///< at the last sample
  Angle angle_[kNodes];
  int head_ = 0, count_ = 0;  ///< slot of the newest node; how many there are
  bool began_ = false;
};

}  // namespace SEGCAL_NS
