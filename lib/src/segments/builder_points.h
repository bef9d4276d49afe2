// SegmentBuilder: image points on their way into a segment, and which tracks get a place among its landmarks.
#pragma once

#include "segments/builder.h"

namespace SEGCAL_NS {

/// A point of the newest keyframe. Each keyframe may use what those before it left of their even shares: without this
/// the last ones of a segment with many tracks would have no points at all.
template <class S>
void SegmentBuilder<S>::add_point(const TrackPoint<S>& point) {
  Segment<S>& s = *segment_;
  const int k = s.n_keyframes - 1;
  const float u = static_cast<float>(point.uv.x()), v = static_cast<float>(point.uv.y());
  if (s.n_observations >= kMaxObservations * (k + 1) / kMaxKeyframes || !fits(u) || !fits(v)) {
    ++counts_.points_left_out;
    return;
  }
  const int j = landmark_of(point.id);
  if (j < 0) {
    ++counts_.landmarks_left_out;
    return;
  }
  if (is_in_newest(j, point.camera)) {
    ++counts_.points_repeated;
    return;
  }
  s.observation[s.n_observations++] = {u,
                                       v,
                                       static_cast<ObservationBits>(j),
                                       static_cast<ObservationBits>(k),
                                       static_cast<ObservationBits>(point.camera),
                                       0};
  last_seen_[j] = static_cast<std::uint8_t>(k);
  ++seen_[j];
}

/// Whether the newest keyframe holds a point of this landmark in this camera. At most one per keyframe and camera is
/// what bounds a landmark's rows (kLandmarkBlockRows).
template <class S>
bool SegmentBuilder<S>::is_in_newest(int landmark, int camera) const {
  const Segment<S>& s = *segment_;
  const unsigned newest = static_cast<unsigned>(s.n_keyframes - 1);
  if (seen_[landmark] == 0 || last_seen_[landmark] != newest) return false;
  for (int o = s.n_observations - 1; o >= 0 && s.observation[o].keyframe == newest; --o) {
    const Observation& z = s.observation[o];
    if (int(z.landmark) == landmark && int(z.camera) == camera) return true;
  }
  return false;
}

/// The track's place; a new one for a new track; -1 if there is none.
template <class S>
int SegmentBuilder<S>::landmark_of(std::uint32_t track_id) {
  for (int j = 0; j < segment_->n_landmarks; ++j) {
    if (segment_->track_id[j] == track_id) return j;
  }
  const int j = free_landmark();
  if (j < 0) return -1;
  segment_->track_id[j] = track_id;
  seen_[j] = 0;
  last_seen_[j] = static_cast<std::uint8_t>(segment_->n_keyframes - 1);
  return j;
}

/// A place for a new track: an unused one, or that of the ended track with the fewest points, if they are fewer than
/// the new one can still collect.
template <class S>
int SegmentBuilder<S>::free_landmark() {
  if (segment_->n_landmarks < kMaxLandmarks) return segment_->n_landmarks++;
  const int now = segment_->n_keyframes - 1, remaining = kMaxKeyframes - now;
  int worst = -1;
  for (int j = 0; j < kMaxLandmarks; ++j) {
    if (last_seen_[j] + 1 >= now || seen_[j] * 2 > remaining) continue;
    if (worst < 0 || seen_[j] < seen_[worst]) worst = j;
  }
  if (worst >= 0) {
    remove_landmark(worst);
    ++counts_.landmarks_left_out;
  }
  return worst;
}

template <class S>
void SegmentBuilder<S>::remove_landmark(int j) {
  int kept = 0;
  for (int o = 0; o < segment_->n_observations; ++o) {
    if (segment_->observation[o].landmark != j) segment_->observation[kept++] = segment_->observation[o];
  }
  segment_->n_observations = kept;
}

}  // namespace SEGCAL_NS
