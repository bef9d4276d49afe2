// Images in, rates of pairs of them out, in slices: rays of the
// corners, which of them the image before has too, and how it turned.
#pragma once

#include <cstdint>

#include "clock/criteria.h"
#include "clock/turn_between.h"
#include "sensors/camera.h"

namespace SEGCAL_NS {

/// A pair of images: its stamps, of the camera's clock, and its rate in I, rad/s.
template <class S>
struct TurnedPair {
  std::int64_t t1_ns, t2_ns;
  Vec3<S> v;
};

template <class S>
class ImageTurns {
 public:
  static constexpr int kPoints = SEGCAL_MAX_TRACKS;

  void reset(const CameraCalibration<S>& camera) {
    camera_ = camera;
    forget();
  }
  /// No image is known, and none is worked on.
  void forget() {
    last_ = 0;
    image_[0].n = -1;
    work_ = Work::nothing;
  }
  bool busy() const { return work_ != Work::nothing; }
  /// The image is so soon after the one before that it is left out: noise, and no rotation.
  bool too_soon(std::int64_t t_ns) const {
    const Image& before = image_[busy() ? 1 - last_ : last_];
    const std::int64_t dt = t_ns - before.t_ns;
    return before.n >= 0 && dt > 0 && dt < static_cast<std::int64_t>(1e9 * clock_criteria::kShortest_s);
  }

  /// The next image; not while busy. Its points follow.
  void begin(std::int64_t t_ns) {
    Image& next = image_[1 - last_];
    next.t_ns = t_ns;
    next.n = 0;
    at_ = kept_ = matches_ = 0;
    work_ = Work::rays;
  }
  /// At most kPoints of them.
  void add(std::uint32_t id, S u, S v) {
    Image& next = image_[1 - last_];
    next.id[next.n] = id;
    next.ray[next.n++] = Vec3<S>(u, v, S(0));  // in pixels until its turn comes
  }

  /// A slice; true when it has made *pair.
  bool step(TurnedPair<S>* pair) {
    if (work_ == Work::rays) {
      take_points();
      return false;
    }
    const Image &before = image_[last_], &next = image_[1 - last_];
    for (int k = 0; k < matches_; ++k) turn_.add(before.ray[match_[k].before], next.ray[match_[k].next]);
    const bool solved = turn_.end_round();
    if (solved && !turn_.done()) return false;
    if (solved) {
      pair->t1_ns = before.t_ns;
      pair->t2_ns = next.t_ns;
      pair->v = camera_.R_CI.transpose() * (turn_.turned() / seconds_between());
    }
    end_image();
    return solved && is_finite(pair->v.squaredNorm());
  }

 private:
  enum class Work : std::int32_t { nothing, rays, turn };
  static constexpr int kPointsOfSlice = 8;  // an inverse of the lens takes some 2,000 instructions on a microcontroller

  struct Image {
    std::int64_t t_ns;
    std::int32_t n;  ///< -1: there is none
    std::uint32_t id[kPoints];
    Vec3<S> ray[kPoints];
  };
  struct Match {
    std::uint16_t before, next;
  };
  static_assert(kPoints < 65536, "a match has 16 bits for each");

  S seconds_between() const { return static_cast<S>(image_[1 - last_].t_ns - image_[last_].t_ns) * S(1e-9); }

  void end_image() {
    last_ = 1 - last_;
    work_ = Work::nothing;
  }

  static int find(const Image& image, int n, std::uint32_t id) {
    int i = 0;
    while (i < n && image.id[i] != id) ++i;
    return i;
  }

  void take_points() {
    Image& next = image_[1 - last_];
    for (int n = 0; n < kPointsOfSlice && at_ < next.n; ++n) take_point(&next, at_++);
    if (at_ < next.n) return;
    next.n = kept_;
    const bool pair = matches_ >= clock_criteria::kLeastRays && next.t_ns > image_[last_].t_ns &&
                      seconds_between() >= S(clock_criteria::kShortest_s) &&
                      seconds_between() <= S(clock_criteria::kLongest_s);
    if (!pair) return end_image();
    turn_.begin();
    work_ = Work::turn;
  }

  /// Its ray, moved to the place behind those that are kept. A track that comes twice counts once: the first point.
  void take_point(Image* next, int i) {
    const std::uint32_t id = next->id[i];
    if (find(*next, kept_, id) < kept_) return;
    Vec3<S> h;
    if (!unproject<S>(camera_, Vec2<S>(next->ray[i].x(), next->ray[i].y()), &h)) return;
    const S length2 = h.x() * h.x() + h.y() * h.y() + h.z() * h.z();
    if (!is_finite(length2)) return;
    const S shorter = S(1) / square_root(length2);
    next->id[kept_] = id;
    next->ray[kept_] = Vec3<S>(h.x() * shorter, h.y() * shorter, h.z() * shorter);
    const Image& before = image_[last_];
    const int k = find(before, before.n, id);
    if (k < before.n) match_[matches_++] = {static_cast<std::uint16_t>(k), static_cast<std::uint16_t>(kept_)};
    ++kept_;
  }

  CameraCalibration<S> camera_;
  TurnBetween<S> turn_;
  Work work_ = Work::nothing;
  int last_ = 0, at_ = 0, kept_ = 0, matches_ = 0;  ///< `last_`: which of the two is the image before
  Image image_[2];
  Match match_[kPoints];
};

}  // namespace SEGCAL_NS
