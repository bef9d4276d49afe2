// Cuts segments from the stream: collects keyframes, image points and raw IMU samples in fixed arrays, then sorts and
// triangulates. More tracks than places: those seen most often stay. Everything left out is counted.
#pragma once

#include "math/near.h"
#include "math/resumable.h"
#include "segments/observation_order.h"
#include "segments/triangulation.h"
#include "sensors/imu_history.h"
#include "sensors/track_point.h"

namespace SEGCAL_NS {

/// m from the origin beyond which the next segment gets one of its own: float resolves 8 um there, a tenth of what an
/// IMU link of a keyframe's distance knows.
constexpr double kFarPlace = 100;

/// What did not fit, since the start.
struct BuilderCounts {
  std::uint32_t landmarks_left_out = 0, points_left_out = 0, ended_early = 0, not_triangulated = 0;
  std::uint32_t points_repeated = 0;  ///< the same track twice in one image: the first point stays
};

template <class S>
struct StoredFields;  // store/stored_fields.h

template <class S>
class SegmentBuilder {
  friend struct StoredFields<S>;

 public:
  /// Starts an empty segment in `slot`. `continues`: its first keyframe follows the last one of the segment before
  /// without a break, and the samples in between are kept.
  void begin(Segment<S>* slot, std::uint32_t session, std::uint32_t serial, bool continues) {
    segment_ = slot;
    segment_->session = session;
    segment_->serial = serial;
    segment_->n_keyframes = segment_->n_landmarks = segment_->n_observations = 0;
    segment_->lead_us = 0;
    segment_->turned_only = segment_->wide_depth_prior = false;
    segment_->imu.clear(gyro_range_, accel_range_);
    if (!continues) last_keyframe_ns_ = kNever;
  }
  /// The segment goes on in another slot.
  void move_to(Segment<S>* slot) {
    *slot = *segment_;
    segment_ = slot;
  }
  /// The slots have moved by so many bytes, and the builder has not.
  void follow(std::ptrdiff_t bytes) { segment_.follow(bytes); }
  bool empty() const { return segment_->n_keyframes == 0; }
  int keyframes() const { return segment_->n_keyframes; }
  bool full() const { return segment_->n_keyframes == kMaxKeyframes; }
  std::int64_t start_ns() const { return segment_->t0_ns; }
  std::int64_t last_keyframe_ns() const { return last_keyframe_ns_; }
  const BuilderCounts& counts() const { return counts_; }
  /// Forgets the counts; ranges of the sensors in rad/s and m/s^2.
  void reset(S gyro_range, S accel_range) {
    counts_ = BuilderCounts{};
    for (double& o : origin_) o = 0;
    gyro_range_ = gyro_range;
    accel_range_ = accel_range;
  }

  /// Adds a keyframe. False if it does not fit any more (keyframes or IMU samples): close the segment, begin the next.
  /// `shift_ns`: how far t_ns is from the camera's stamp. All keyframes of a segment have the same: one with another is
  /// left out. `origin`: what state.p_GI counts from, m.
  bool add_keyframe(std::int64_t t_ns, std::int32_t shift_ns, const State<S>& state, const double* origin,
                    const TrackPoint<S>* points, int n, const ImuHistory<S>& imu);

  /// Drops every second keyframe with its image points: the segment can grow to twice its length. All IMU samples stay.
  void thin();

  /// Worth to be closed.
  bool long_enough() const { return segment_->n_keyframes >= kFewestKeyframes; }
  /// Ends a segment that has left the builder: sorts, triangulates at
  /// theta, drops what cannot be used. In slices; true when useful() tells.
  bool close_step(Segment<S>* closed, const Calibration<S>& theta, const MeasurementModel<S>& model);
  void restart_close() { place_ = 0; }
  static bool useful(const Segment<S>& closed) { return closed.n_landmarks >= kFewestLandmarks; }

 private:
  static constexpr std::int64_t kNever = INT64_MIN;
  static constexpr int kFewestKeyframes = 4, kFewestLandmarks = 5;
  bool copy_imu(std::int64_t from_ns, std::int64_t to_ns, const ImuHistory<S>& imu);
  void place_origin(const State<S>& state, const double* origin);
  void add_point(const TrackPoint<S>& point);
  bool is_in_newest(int landmark, int camera) const;
  int landmark_of(std::uint32_t track_id);
  int free_landmark();
  void remove_landmark(int j);

  Near<Segment<S>> segment_;
  std::int64_t last_keyframe_ns_ = kNever;
  std::uint8_t last_seen_[kMaxLandmarks];  // keyframe
  std::uint16_t seen_[kMaxLandmarks];      // image points
  double origin_[3] = {0, 0, 0};           // of the newest segment
  S gyro_range_ = S(35), accel_range_ = S(157);
  BuilderCounts counts_;
  Place place_ = 0;  // of close_step()
  std::int32_t j_ = 0;
};

template <class S>
bool SegmentBuilder<S>::copy_imu(std::int64_t from_ns, std::int64_t to_ns, const ImuHistory<S>& imu) {
  Segment<S>& s = *segment_;
  for (int i = imu.at_or_before(from_ns); i < imu.size(); ++i) {
    const std::int64_t offset_ns = imu.time(i) - s.t0_ns;
    const std::int32_t t_us = static_cast<std::int32_t>((offset_ns + (offset_ns < 0 ? -500 : 500)) / 1000);
    if (s.imu.size() > 0 && t_us <= s.imu.time(s.imu.size() - 1)) continue;
    if (!s.imu.push(t_us, imu.reading(i))) return false;
    if (imu.time(i) >= to_ns) break;
  }
  return true;
}

template <class S>
[[gnu::cold]] bool SegmentBuilder<S>::add_keyframe(std::int64_t t_ns, std::int32_t shift_ns, const State<S>& state,
                                                   const double* origin, const TrackPoint<S>* points, int n,
                                                   const ImuHistory<S>& imu) {
  Segment<S>& s = *segment_;
  if (s.n_keyframes == kMaxKeyframes) return false;
  if (empty()) {
    s.t0_ns = t_ns;
    s.stamp_shift_ns = shift_ns;
    place_origin(state, origin);
    const bool leads = last_keyframe_ns_ != kNever && imu.covers(last_keyframe_ns_, t_ns);
    s.lead_us = leads ? static_cast<std::int32_t>((t_ns - last_keyframe_ns_ + 500) / 1000) : 0;
    last_keyframe_ns_ = leads ? last_keyframe_ns_ : t_ns;
  }
  if (shift_ns != s.stamp_shift_ns) return true;
  if (!copy_imu(last_keyframe_ns_, t_ns, imu)) {
    ++counts_.ended_early;
    return false;
  }
  const int k = s.n_keyframes++;
  s.t_us[k] = static_cast<std::int32_t>((t_ns - s.t0_ns + 500) / 1000);
  s.warmth[k] = static_cast<float>(imu.warmth());
  s.states.x[k] = state;
  for (int i = 0; i < 3; ++i)
    s.states.x[k].p_GI(i) = static_cast<S>(origin[i] - s.origin[i] + static_cast<double>(state.p_GI(i)));
  last_keyframe_ns_ = t_ns;
  // The cameras take turns, so that the first does not fill the places of the others.
  int next[kMaxCameras] = {};
  for (int c = 0, ended = 0; ended < kMaxCameras; c = (c + 1) % kMaxCameras) {
    while (next[c] < n && points[next[c]].camera != c) ++next[c];
    ended = next[c] < n ? 0 : ended + 1;
    if (next[c] < n) add_point(points[next[c]++]);
  }
  return true;
}

/// The segment's origin: that of the segment before, so that landmarks can be shared, or this position if that is far.
template <class S>
void SegmentBuilder<S>::place_origin(const State<S>& state, const double* origin) {
  double distance = 0;
  for (int i = 0; i < 3; ++i) {
    const double d = absolute(origin[i] + static_cast<double>(state.p_GI(i)) - origin_[i]);
    distance = d > distance ? d : distance;
  }
  for (int i = 0; i < 3; ++i) {
    if (distance > kFarPlace) origin_[i] = origin[i] + static_cast<double>(state.p_GI(i));
    segment_->origin[i] = origin_[i];
  }
}

template <class S>
void SegmentBuilder<S>::thin() {
  Segment<S>& s = *segment_;
  int kept = 0;
  for (int j = 0; j < s.n_landmarks; ++j) seen_[j] = 0;
  for (int o = 0; o < s.n_observations; ++o) {
    Observation z = s.observation[o];
    if (z.keyframe % 2 != 0) continue;
    z.keyframe = static_cast<ObservationBits>(z.keyframe / 2);
    s.observation[kept++] = z;
    ++seen_[z.landmark];
  }
  s.n_observations = kept;
  for (int j = 0; j < s.n_landmarks; ++j) last_seen_[j] = static_cast<std::uint8_t>(last_seen_[j] / 2);
  s.n_keyframes = (s.n_keyframes + 1) / 2;
  for (int k = 0; k < s.n_keyframes; ++k) {
    s.t_us[k] = s.t_us[2 * k];
    s.warmth[k] = s.warmth[2 * k];
    s.states.x[k] = s.states.x[2 * k];
  }
  // The next segment hangs on the last keyframe that is still there.
  last_keyframe_ns_ = s.t0_ns + std::int64_t(s.t_us[s.n_keyframes - 1]) * 1000;
}

template <class S>
bool SegmentBuilder<S>::close_step(Segment<S>* closed, const Calibration<S>& theta, const MeasurementModel<S>& model) {
  Segment<S>& s = *closed;
  // Mean squared whitened residual under a robust cost: the intrinsics may still be off by several pixels.
  const S limit = S(60);
  SEGCAL_SLICES(place_) {
    sort_observations(closed);
    index_observations(closed, 3);
    for (j_ = 0; j_ < s.n_landmarks; ++j_) {
      SEGCAL_PAUSE(place_);
      if (triangulate(closed, j_, theta, model, limit)) continue;
      ++counts_.not_triangulated;
      for (int o = s.first_observation[j_]; o < s.first_observation[j_ + 1]; ++o)
        s.observation[o].landmark = kDroppedLandmark;
    }
    index_observations(closed, 1);
  }
  SEGCAL_SLICES_END(place_);
}

}  // namespace SEGCAL_NS

#include "segments/builder_points.h"
