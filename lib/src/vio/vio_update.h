// Features into the filter: landmark eliminated, gated, folded.
#pragma once

#include "math/quantiles.h"
#include "vio/feature_walk.h"
#include "vio/window_update.h"

namespace SEGCAL_NS {

constexpr int kMinTrackLength = 3;
constexpr int kMaxFeaturesPerFrame = 30;  // bounds the time of a frame

/// A filter on its path refuses up to a quarter of its features and needs a scale of 1 to 1.5. A lost one explains its
/// residuals by an ever larger scale, which also opens the gate; and rays from a wrong path do not meet.
template <class S>
constexpr S kMostRefused = S(0.35);
template <class S>
constexpr S kLargestScale = S(3);

/// Follows how large residuals are against their sigmas. A calibration that does not fit yet makes them all larger:
/// then the pixel sigma grows with them, and shrinks again when they do.
template <class S>
struct ResidualMonitor {
  S scale = S(1);                      ///< factor on pixel_sigma, 1..4
  S rho_sigma = kFilterDepthSigma<S>;  ///< 1/m; prior of the inverse distances
  S nearness = S(0.3);                 ///< 1/m; running mean of the features' inverse distance
  S refused_share = S(0);  ///< running share of features that the gate refused or that no point in space explains

  /// `ratio`: Mahalanobis distance by degrees of freedom, at the present scale.
  void note(S ratio, bool gated) {
    note_refused(gated);
    const S wanted = scale * scale * (ratio < S(6) ? ratio : S(6));
    S square = scale * scale + S(0.02) * (wanted - scale * scale);
    if (square < S(1)) square = S(1);
    if (square > S(16)) square = S(16);
    scale = square_root(square);
  }
  /// Only where parallax tells it, near or far.
  void note_distance(S rho, S sigma_rho) {
    if (sigma_rho < S(0.15)) nearness += S(0.02) * ((rho > S(0) ? rho : S(0)) - nearness);
  }
  void note_refused(bool refused) { refused_share += S(0.02) * ((refused ? S(1) : S(0)) - refused_share); }
  bool failing() const { return refused_share > kMostRefused<S> || scale > kLargestScale<S>; }
};

/// Writes the rows of one feature into the block: the landmark's three columns just before the first pose's.
/// Returns the number of rows, 0 where a point has no image.
template <class S>
int feature_rows(Window<S>* w, const TrackView<S>& view, const Landmark<S>& l, S rho_sigma, S pixel_sigma, S walk,
                 int camera_columns) {
  const int camera_index = view.track->camera, n = w->columns();
  const CameraCalibration<S>& camera = w->theta.camera[camera_index];
  const int landmark = pose_column(view.pose[0]) - kLandmarkColumns;
  const S weight = S(1) / pixel_sigma;
  w->clear_block(2 * view.n + 1);
  for (int i = 0; i < view.n; ++i) {
    const WindowPose<S>& pose = w->pose[view.pose[i]];
    ReprojectionRows<S> rows;
    Vec2<S> r;
    // Jacobians at first estimates of pose and camera, residual at the present ones.
    if (!reprojection_rows(w->camera_first[camera_index], pose.R_first, pose.p_first, pose.R_first, pose.p_first, l,
                           view.uv(*w, i), &rows))
      return 0;
    if (!reprojection_residual(camera, pose.R_GI, pose.p_GI, l, view.uv(*w, i), &r)) return 0;
    for (int k = 0; k < 2; ++k) {
      S* row = w->block + (2 * i + k) * kBlockStride;
      for (int c = 0; c < kLandmarkColumns; ++c) row[landmark + c] = rows.J_l(k, c) * weight;
      for (int c = 0; c < kPoseColumns; ++c) row[pose_column(view.pose[i]) + c] = rows.J_pose(k, c) * weight;
      for (int c = 0; c < camera_columns; ++c) row[camera_column(camera_index) + c] = rows.J_camera(k, c) * weight;
      row[n] = -r(k) * weight;
    }
  }
  if constexpr (kTrackWalk) {
    if (walk > S(0)) whiten_walk(w, view, walk, landmark, n + 1);
  }
  S* distance = w->block + 2 * view.n * kBlockStride;
  distance[landmark + 2] = S(1) / rho_sigma;
  distance[n] = -l.rho / rho_sigma;
  return 2 * view.n + 1;
}

template <class S>
bool finite_rows(const S* rows, int n_rows, int first, int last) {
  S sum = S(0);
  for (int i = 0; i < n_rows; ++i) {
    for (int c = first; c <= last; ++c) sum += rows[i * kBlockStride + c] * rows[i * kBlockStride + c];
  }
  return is_finite(sum);
}

/// One track on its way into R.
template <class S>
struct Feature {
  int first = 0, dof = 0;          ///< first column and number of the rows that are left without the landmark
  bool finite = false;             ///< what is not a number could not be taken back
  S rho = S(0), sigma_rho = S(1);  ///< inverse distance, 1/m
};

/// The rows of a feature without its landmark.
template <class S>
S* feature_rest(Window<S>* w) {
  return w->block + kLandmarkColumns * kBlockStride;
}

/// Puts a track's rows into the block and eliminates its landmark. False: not enough points, or no landmark.
template <class S>
bool prepare_feature(Window<S>* w, const VioTrack<S>& track, const VioOptions<S>& options, ResidualMonitor<S>* monitor,
                     VioStatistics* statistics, Feature<S>* f) {
  const TrackView<S> view = view_of(*w, track);
  if (view.n < kMinTrackLength) return false;
  const S sigma = options.pixel_sigma * monitor->scale;
  const int camera_columns = options.sigma_focal > S(0) ? kMaxCameraColumns : kExtrinsicColumns;
  Landmark<S> l;
  int rows = 0;
  *f = Feature<S>();
  if (triangulate(*w, view, sigma, w->block, &l, monitor->rho_sigma, &f->sigma_rho)) {
    rows = feature_rows(w, view, l, monitor->rho_sigma, sigma, options.walk_variance(), camera_columns);
  }
  if (rows == 0) {
    ++statistics->not_triangulated;
    monitor->note_refused(true);
    return false;
  }
  f->rho = l.rho;
  f->first = pose_column(view.pose[0]);
  f->dof = rows - kLandmarkColumns;
  const int landmark = f->first - kLandmarkColumns, n = w->columns();
  reflect_leading_columns(w->block + landmark, rows, kBlockStride, n + 1 - landmark, kLandmarkColumns);
  f->finite = finite_rows(feature_rest(w), f->dof, f->first, n);
  if (!f->finite) ++statistics->gated;
  return f->finite;
}

/// The gate. The residual that R cannot absorb is the innovation's
/// Mahalanobis distance, given the features folded before it.
template <class S>
bool passes_gate(const Feature<S>& f, S distance, ResidualMonitor<S>* monitor, VioStatistics* statistics) {
  const bool accepted = distance < chi_square_gate<S>(f.dof);
  monitor->note(distance / S(f.dof), !accepted);
  if (accepted) monitor->note_distance(f.rho, f.sigma_rho);
  ++(accepted ? statistics->updates : statistics->gated);
  return accepted;
}

/// One track into R. False: not enough points, no landmark, or gated.
template <class S>
bool use_track(Window<S>* w, const VioTrack<S>& track, const VioOptions<S>& options, ResidualMonitor<S>* monitor,
               VioStatistics* statistics) {
  Feature<S> f;
  if (!prepare_feature(w, track, options, monitor, statistics, &f)) return false;
  const S distance = fold_block(w, feature_rest(w), f.dof, f.first);
  if (passes_gate(f, distance, monitor, statistics)) return true;
  unfold_block(w, feature_rest(w), f.dof, f.first);
  return false;
}

/// Products of folding `rows` rows over `columns` columns.
constexpr int fold_work(int rows, int columns) { return rows * columns * columns / 2; }
/// Triangulating a track and writing its rows takes as long as so many products for each of its points: 15,400
/// instructions of some nine a product. Without it thirty short tracks, as where a tracker detects all corners anew,
/// cost a fifth more than six long ones.
constexpr int kPointWork = 1800;
/// What the features of one frame may cost: as much as SEGCAL_FRAME_FEATURES of the longest tracks.
constexpr int kFrameWork =
    SEGCAL_FRAME_FEATURES *
    (fold_work(kFeatureRows - kLandmarkColumns, kFilterColumns + 1 - pose_column(0)) + kPointWork * (kFeatureRows / 2));

/// What a frame's inertial link has cost of that beyond the usual: after a gap in the images, or where they are slow,
/// there are more samples to integrate, and fewer features are used then. A sample, integrated for the filter and
/// looked at for rest, takes as long as some 2000 products.
constexpr int kUsualSamples = 25, kSampleWork = 2000;
constexpr int link_work(int samples) { return samples > kUsualSamples ? (samples - kUsualSamples) * kSampleWork : 0; }

/// What folding a track costs at most, once its landmark is gone; and whitening its rows, which is not taken back.
struct TrackWork {
  int fold, whiten;
};

template <class S>
TrackWork track_work(const Window<S>& w, const VioTrack<S>& track, const VioOptions<S>& options) {
  int first = 0;
  while (first < w.n_poses && !track.in(w.pose[first].slot)) ++first;
  const int columns = w.columns() + 1 - pose_column(first);
  const bool walks = kTrackWalk && options.track_walk > S(0);
  return {fold_work(2 * track.length() + 1 - kLandmarkColumns, columns), walks ? 2 * track.length() * columns : 0};
}

/// Uses the tracks that `due` names, as many as a frame has time for, of which `work` is spent, and updates the state.
/// Ended tracks leave the table; a track that lives on begins anew with its next point, since each point is used once,
/// or waits for the next frame if it had no turn. Returns the number of features used.
template <class S, class Due>
int use_tracks(Window<S>* w, TrackTable<S>* tracks, const VioOptions<S>& options, ResidualMonitor<S>* monitor,
               VioStatistics* statistics, int work, Due due) {
  int used = 0, tried = 0;
  for (int i = 0; i < tracks->end(); ++i) {
    VioTrack<S>& track = (*tracks)[i];
    if (!track.used || !due(track)) continue;
    const TrackWork its = track_work(*w, track, options);
    const int once = its.fold + its.whiten + kPointWork * track.length();
    if (tried < kMaxFeaturesPerFrame && work + once <= kFrameWork && track.length() >= kMinTrackLength) {
      ++tried;
      const bool accepted = use_track(w, track, options, monitor, statistics);
      work += accepted ? once : once + its.fold;  // folded and taken back
      used += accepted ? 1 : 0;
      track.slots = 0;
    }
    if (!track.alive) track.used = false;
  }
  if (used) apply_update(w);
  return used;
}

template <class S>
int use_ended_tracks(Window<S>* w, TrackTable<S>* tracks, const VioOptions<S>& options, ResidualMonitor<S>* monitor,
                     VioStatistics* statistics, int spent) {
  return use_tracks(w, tracks, options, monitor, statistics, spent,
                    [](const VioTrack<S>& track) { return !track.alive; });
}

/// Also the tracks that the oldest pose sees: it is about to leave.
template <class S>
int use_leaving_tracks(Window<S>* w, TrackTable<S>* tracks, const VioOptions<S>& options, ResidualMonitor<S>* monitor,
                       VioStatistics* statistics, int spent) {
  const int slot = w->pose[0].slot;
  return use_tracks(w, tracks, options, monitor, statistics, spent,
                    [slot](const VioTrack<S>& track) { return !track.alive || track.in(slot); });
}

}  // namespace SEGCAL_NS
