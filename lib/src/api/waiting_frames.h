// Frames that wait until IMU samples reach them: sensors with a FIFO
// deliver blocks, and several images come before the samples of the first.
#pragma once

#include "sensors/inertial_state.h"
#include "sensors/track_point.h"

namespace SEGCAL_NS {

constexpr int kMaxFramePoints = SEGCAL_MAX_TRACKS * kMaxCameras;

/// An image's points with its stamp, and what was added to the stamp when it came: a time offset that is released later
/// applies to the frames that come after it.
template <class S>
struct Frame {
  std::int64_t stamp_ns = 0;  ///< camera's clock
  std::int32_t shift_ns = 0;  ///< from there to the IMU's
  std::int32_t n = 0;
  bool own = false;  ///< with a state of the user's odometry
  State<S> state;    ///< that one, without its place
  double p_GI[3];    ///< its place, m, in the user's frame
  TrackPoint<S> points[kMaxFramePoints];

  std::int64_t time_ns() const { return stamp_ns + shift_ns; }
};

/// What was left out of a frame on its way in.
struct LeftOut {
  std::uint32_t not_finite = 0, repeated = 0;
};

/// First in, first out.
template <class S>
class WaitingFrames {
 public:
  void clear() { first_ = count_ = 0; }
  bool empty() const { return count_ == 0; }
  bool full() const { return count_ == kPlaces; }
  Frame<S>& front() { return frame_[first_]; }
  Frame<S>& newest() { return frame_[(first_ + count_ - 1) % kPlaces]; }
  /// A place at the end; there must be one.
  Frame<S>& append(std::int64_t stamp_ns, std::int32_t shift_ns) {
    Frame<S>& frame = frame_[(first_ + count_++) % kPlaces];
    frame.stamp_ns = stamp_ns;
    frame.shift_ns = shift_ns;
    frame.n = 0;
    frame.own = false;
    return frame;
  }
  void drop_front() {
    first_ = (first_ + 1) % kPlaces;
    --count_;
  }

 private:
  static constexpr int kPlaces = SEGCAL_WAITING_FRAMES;
  std::int32_t first_ = 0, count_ = 0;
  Frame<S> frame_[kPlaces];
};

/// Largest image coordinate taken, px: beyond it a number is no pixel of any sensor, and squares stay far inside float.
template <class S>
constexpr S kMostPixels = S(1e6);

/// Copies the points that are numbers and whose track the frame
/// does not hold yet, per camera. Reads point i as `point(i)`.
template <class S, class Point>
LeftOut take_points(int n, Point point, Frame<S>* frame) {
  LeftOut out;
  for (int i = 0; i < n && frame->n < kMaxFramePoints; ++i) {
    const TrackPoint<S> p = point(i);
    if (!(absolute(p.uv.x()) <= kMostPixels<S> && absolute(p.uv.y()) <= kMostPixels<S>)) {
      ++out.not_finite;
      continue;
    }
    int same = 0;
    while (same < frame->n && (frame->points[same].id != p.id || frame->points[same].camera != p.camera)) ++same;
    if (same < frame->n) {
      ++out.repeated;
    } else {
      frame->points[frame->n++] = p;
    }
  }
  return out;
}

}  // namespace SEGCAL_NS
