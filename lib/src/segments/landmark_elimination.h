// One landmark's rows, eliminated alone: three reflections clear its columns, and what is left (the left null space)
// has pose and camera columns only (docs/design.md, section 5, step 1; Mourikis and Roumeliotis 2007, Sec. III-D).
//
// Columns of the block: 3 free ones, then the reduced system's, right-hand side -r. The landmark's own columns stand
// right before the first pose that sees it, so that the columns before need neither be cleared nor reflected. Rows: one
// for the prior on the inverse depth, three for damping if there is any, two per image point. The points' rows are
// whitened together where tracks drift (track_noise.h).
//
// A tied landmark (calibration/ties.h) stays: its rows are the image points' alone, and stand in the tie's columns.
#pragma once

#include "segments/depth_prior.h"
#include "segments/reduced_system.h"
#include "segments/track_noise.h"

namespace SEGCAL_NS {

constexpr int kLandmarkBlockWidth = kLandmarkColumns + kReducedColumns;
constexpr int kLandmarkBlockRows = 2 * kMaxKeyframes * kMaxCameras + 4;

/// What the fit of one landmark amounts to.
template <class S>
struct LandmarkFit {
  int rows = 0;                               ///< in the block
  int used = 0;                               ///< image points with weight
  int first_keyframe = 0, last_keyframe = 0;  ///< of the image points, with weight or not
  S prior_share = S(0);  ///< part of the inverse depth's information that is prior: counts towards dof
};

template <class S>
class LandmarkBlock {
 public:
  /// Writes the whitened rows of landmark j at the segment's current states. `camera_terms`: those that the layout has
  /// columns for. `damping`: 0 for none, else the square root
  /// of lambda times one over the landmark's typical step.
  LandmarkFit<S> build(const Segment<S>& segment, int j, const Calibration<S>& theta, const MeasurementModel<S>& model,
                       const ReducedLayout& layout, const Term* camera_terms, S damping);
  /// The rows of the landmark that is tie t of this segment: image points only, in the tie's columns.
  LandmarkFit<S> build_tied(const Segment<S>& segment, int t, const Calibration<S>& theta,
                            const MeasurementModel<S>& model, const ReducedLayout& layout, const Term* camera_terms);
  /// The three reflections; afterwards rows [3, rows) are free of the landmark.
  void eliminate(LandmarkFit<S>* fit);
  /// Rows after elimination, beginning at the first pose column.
  S* rest() { return tied_rows() + kLandmarkColumns * stride_; }
  /// All rows of a tied landmark, beginning at the first pose column.
  S* tied_rows() { return data_ + kLandmarkColumns; }
  int stride() const { return stride_; }
  /// Landmark step for given steps of poses and cameras (`step`, in the reduced layout).
  void solve(const S* step, S* landmark_step) const;

 private:
  S* row(int i) { return data_ + i * stride_; }
  /// The landmark's three columns of a row.
  S* own(int i) { return row(i) + column_; }
  const S* own(int i) const { return data_ + i * stride_ + column_; }
  void clear(int i) {
    for (int c = first_; c < stride_; ++c) row(i)[c] = S(0);
  }
  bool add_observation(const Segment<S>& segment, int j, const Observation& o, const Calibration<S>& theta,
                       const MeasurementModel<S>& model, const ReducedLayout& layout, const Term* camera_terms,
                       TrackNoise<S>* track);
  void find_keyframes(const Segment<S>& segment, int j, LandmarkFit<S>* fit) const;
  void write_prior(const DepthPrior<S>& prior, const Calibration<S>& theta, const ReducedLayout& layout);
  /// Rows of the points that have an image; returns their number.
  /// `track`: null, or gathers them, and the rows stay in px.
  int add_points(const Segment<S>& segment, int j, const Calibration<S>& theta, const MeasurementModel<S>& model,
                 const ReducedLayout& layout, const Term* camera_terms, TrackNoise<S>* track);
  void add_observations(const Segment<S>& segment, int j, const Calibration<S>& theta, const MeasurementModel<S>& model,
                        const ReducedLayout& layout, const Term* camera_terms, LandmarkFit<S>* fit);
  int stride_ = 0, rows_ = 0;
  int first_ = 0;   // column from which on rows are in use
  int column_ = 0;  // of the landmark itself
  ColumnGap gap_;   // counted from first_
  S prior_;         // information of the inverse distance, with the direction held, that is prior, m^2
  S data_[kLandmarkBlockRows * kLandmarkBlockWidth];
};

template <class S>
bool LandmarkBlock<S>::add_observation(const Segment<S>& segment, int j, const Observation& o,
                                       const Calibration<S>& theta, const MeasurementModel<S>& model,
                                       const ReducedLayout& layout, const Term* camera_terms, TrackNoise<S>* track) {
  const Landmark<S>& l = segment.states.landmark[j];
  bool time_columns = false;
  for (int t = 0; t < layout.camera_terms; ++t) time_columns |= camera_terms[t].of_time();
  const Exposure<S> exposure = exposure_of(segment, o, theta, model.g, time_columns);
  const Vec3<S>& p_first = segment.states.x[segment.observation[segment.first_observation[j]].keyframe].p_GI;
  ReprojectionRows<S> rows;
  if (!point_rows(o, theta, exposure, l, segment.turned_only ? &p_first : nullptr, &rows)) return false;
  S scale = S(1);
  if (kTrackWalk && track) {  // a build without walks has no code for them
    track->add(o.camera, segment.t_us[o.keyframe], rows.r, model);
  } else {
    const S inverse_sigma = S(1) / model.pixel_sigma;
    scale =
        square_root(robust_term(model, rows.r.squaredNorm() * inverse_sigma * inverse_sigma).weight) * inverse_sigma;
  }
  const int pose = kLandmarkColumns + layout.pose(o.keyframe);
  const int camera = kLandmarkColumns + layout.cameras() + theta.camera_column(o.camera);
  const int n_camera = theta.camera[o.camera].columns();
  for (int i = 0; i < 2; ++i) {
    S* r = row(rows_ + i);
    clear(rows_ + i);
    for (int c = 0; c < kLandmarkColumns; ++c) own(rows_ + i)[c] = scale * rows.J_l(i, c);
    for (int c = 0; c < 6; ++c) r[pose + c] = scale * rows.J_pose(i, c);
    for (int c = 0; c < n_camera; ++c) r[camera + c] = scale * rows.J_camera(i, c);
    r[stride_ - 1] = -scale * rows.r(i);
  }
  const int first_term = kLandmarkColumns + layout.cameras() + layout.sensor_cameras;
  for (int t = 0; t < layout.camera_terms; ++t) {
    const Vec2<S> column = camera_term_column(camera_terms[t], o, theta, exposure, segment.turned_only, rows);
    for (int i = 0; i < 2; ++i) row(rows_ + i)[first_term + t] = scale * column(i);
  }
  rows_ += 2;
  return true;
}

/// Row 0.
template <class S>
void LandmarkBlock<S>::write_prior(const DepthPrior<S>& prior, const Calibration<S>& theta,
                                   const ReducedLayout& layout) {
  const int pose = kLandmarkColumns + layout.pose(prior.keyframe);
  const int camera = kLandmarkColumns + layout.cameras() + theta.camera_column(prior.camera);
  for (int c = 0; c < kLandmarkColumns; ++c) own(0)[c] = prior.row.l(c);
  for (int c = 0; c < 6; ++c) {
    row(0)[pose + c] = prior.row.pose(c);
    row(0)[camera + c] = prior.row.extrinsics(c);
  }
  row(0)[stride_ - 1] = -prior.r;
  prior_ = prior.row.l(2) * prior.row.l(2);
}

/// First and last keyframe of the image points.
template <class S>
void LandmarkBlock<S>::find_keyframes(const Segment<S>& segment, int j, LandmarkFit<S>* fit) const {
  fit->first_keyframe = kMaxKeyframes - 1;
  for (int o = segment.first_observation[j]; o < segment.first_observation[j + 1]; ++o) {
    const int k = segment.observation[o].keyframe;
    if (k < fit->first_keyframe) fit->first_keyframe = k;
    if (k > fit->last_keyframe) fit->last_keyframe = k;
  }
}

template <class S>
LandmarkFit<S> LandmarkBlock<S>::build(const Segment<S>& segment, int j, const Calibration<S>& theta,
                                       const MeasurementModel<S>& model, const ReducedLayout& layout,
                                       const Term* camera_terms, S damping) {
  LandmarkFit<S> fit;
  find_keyframes(segment, j, &fit);
  stride_ = kLandmarkColumns + layout.width();
  first_ = column_ = layout.pose(fit.first_keyframe);
  gap_.first = kLandmarkColumns + layout.pose(fit.last_keyframe + 1) - first_;
  gap_.last = kLandmarkColumns + layout.cameras() - first_;
  const int priors = damping > S(0) ? 4 : 1;
  for (int i = 0; i < priors; ++i) clear(i);
  write_prior(depth_prior(segment, j, segment.states.landmark[j], theta, model), theta, layout);
  for (int i = 1; i < priors; ++i) own(i)[i - 1] = damping;
  rows_ = priors;
  add_observations(segment, j, theta, model, layout, camera_terms, &fit);
  return fit;
}

template <class S>
LandmarkFit<S> LandmarkBlock<S>::build_tied(const Segment<S>& segment, int t, const Calibration<S>& theta,
                                            const MeasurementModel<S>& model, const ReducedLayout& layout,
                                            const Term* camera_terms) {
  LandmarkFit<S> fit;
  const int j = layout.tied.landmark[t];
  find_keyframes(segment, j, &fit);
  stride_ = kLandmarkColumns + layout.width();
  first_ = kLandmarkColumns + layout.pose(fit.first_keyframe);
  column_ = kLandmarkColumns + layout.tie(t);
  gap_ = ColumnGap{};
  rows_ = 0;
  add_observations(segment, j, theta, model, layout, camera_terms, &fit);
  return fit;
}

template <class S>
int LandmarkBlock<S>::add_points(const Segment<S>& segment, int j, const Calibration<S>& theta,
                                 const MeasurementModel<S>& model, const ReducedLayout& layout,
                                 const Term* camera_terms, TrackNoise<S>* track) {
  int used = 0;
  for (int o = segment.first_observation[j]; o < segment.first_observation[j + 1]; ++o) {
    if (segment.observation[o].rejected) continue;
    if (add_observation(segment, j, segment.observation[o], theta, model, layout, camera_terms, track)) ++used;
  }
  return used;
}

template <class S>
void LandmarkBlock<S>::add_observations(const Segment<S>& segment, int j, const Calibration<S>& theta,
                                        const MeasurementModel<S>& model, const ReducedLayout& layout,
                                        const Term* camera_terms, LandmarkFit<S>* fit) {
  const int first_row = rows_;
  if constexpr (kTrackWalk) {
    if (TrackNoise<S>::walks(model)) {
      TrackNoise<S> track;
      fit->used = add_points(segment, j, theta, model, layout, camera_terms, &track);
      track.weigh(model);
      track.whiten(row(first_row), stride_, first_, first_ + gap_.first);
      track.whiten(row(first_row), stride_, first_ + gap_.last, stride_);
      fit->rows = rows_;
      return;
    }
  }
  fit->used = add_points(segment, j, theta, model, layout, camera_terms, nullptr);
  fit->rows = rows_;
}

template <class S>
void LandmarkBlock<S>::eliminate(LandmarkFit<S>* fit) {
  reflect_leading_columns(data_ + first_, rows_, stride_, stride_ - first_, kLandmarkColumns, gap_);
  const S information = own(2)[2] * own(2)[2];
  fit->prior_share = information > S(0) && prior_ < information ? prior_ / information : S(1);
}

template <class S>
void LandmarkBlock<S>::solve(const S* step, S* landmark_step) const {
  for (int i = kLandmarkColumns - 1; i >= 0; --i) {
    const S* r = own(i);
    const int rhs = stride_ - 1 - first_;
    const S sum = less_products(r[rhs], r + kLandmarkColumns, step + first_, 0, rhs - kLandmarkColumns);
    landmark_step[i] = over_pivot(less_products(sum, r, landmark_step, i + 1, kLandmarkColumns), r[i]);
  }
}

}  // namespace SEGCAL_NS
