// A landmark from one track and the window's poses: a first guess from the rays, Gauss-Newton on the pixels after.
#pragma once

#include "math/small_solvers.h"
#include "segments/landmark_guess.h"
#include "vio/vio_tracks.h"

namespace SEGCAL_NS {

/// The observations of one track, in time order.
template <class S>
struct TrackView {
  const VioTrack<S>* track;
  std::int32_t n;
  std::int32_t pose[kWindow];  ///< index into the window

  const Vec2<S>& uv(const Window<S>& w, int i) const { return track->uv[w.pose[pose[i]].slot]; }
};

template <class S>
TrackView<S> view_of(const Window<S>& w, const VioTrack<S>& track) {
  TrackView<S> view;
  view.track = &track;
  view.n = 0;
  for (int i = 0; i < w.n_poses; ++i) {
    if (track.in(w.pose[i].slot)) view.pose[view.n++] = i;
  }
  return view;
}

/// The ray of the track's point i.
template <class S>
bool ray_in_world(const Window<S>& w, const TrackView<S>& view, int i, Vec3<S>* o, Vec3<S>* m) {
  const WindowPose<S>& pose = w.pose[view.pose[i]];
  return ray_in_world(w.theta.camera[view.track->camera], pose.R_GI, pose.p_GI, view.uv(w, i), o, m);
}

template <class S>
bool guess_landmark(const Window<S>& w, const TrackView<S>& view, Landmark<S>* l) {
  if (!ray_in_world(w, view, 0, &l->o, &l->m)) return false;
  LandmarkGuess<S> guess(l);
  for (int i = 1; i < view.n; ++i) {
    Vec3<S> o, m;
    if (ray_in_world(w, view, i, &o, &m)) guess.add(o, m);
  }
  guess.finish();
  return true;
}

/// One normal step of the landmark alone: rows [J_l 3 | -r] reduced by reflections in `rows` (2 n + 1 x 4).
/// `cost` is the sum of squares before the step.
template <class S>
bool landmark_step(const Window<S>& w, const TrackView<S>& view, const Landmark<S>& l, S rho_sigma, S pixel_sigma,
                   S* rows, S* step, S* pivot_rho, S* cost) {
  const CameraCalibration<S>& camera = w.theta.camera[view.track->camera];
  *cost = S(0);
  for (int i = 0; i < view.n; ++i) {
    const WindowPose<S>& pose = w.pose[view.pose[i]];
    ReprojectionRows<S> row;
    if (!reprojection_rows(camera, pose.R_GI, pose.p_GI, pose.R_GI, pose.p_GI, l, view.uv(w, i), &row)) return false;
    for (int k = 0; k < 2; ++k) {
      for (int c = 0; c < 3; ++c) rows[(2 * i + k) * 4 + c] = row.J_l(k, c);
      rows[(2 * i + k) * 4 + 3] = -row.r(k);
    }
    *cost += row.r.squaredNorm();
  }
  const S prior = pixel_sigma / rho_sigma;
  S* last = rows + 8 * view.n;
  last[0] = last[1] = S(0);
  last[2] = prior;
  last[3] = -prior * l.rho;
  *cost += last[3] * last[3];
  reflect_leading_columns(rows, 2 * view.n + 1, 4, 4, 3);
  *pivot_rho = absolute(rows[2 * 4 + 2]);
  for (int j = 2; j >= 0; --j) {
    const S sum = less_products(rows[j * 4 + 3], rows + j * 4, step, j + 1, 3);
    const S p = rows[j * 4 + j];
    step[j] = absolute(p) > S(1e-6) ? sum / p : S(0);
  }
  return true;
}

/// Gauss-Newton from *l. Optional: the inverse distance's sigma,
/// and `points`, to which those that were linearised are added.
template <class S>
bool refine_landmark(const Window<S>& w, const TrackView<S>& view, S pixel_sigma, S* scratch, Landmark<S>* l,
                     S rho_sigma = kFilterDepthSigma<S>, S* sigma_rho = nullptr, std::int32_t* points = nullptr) {
  S step[3], pivot, cost = S(0), last = S(-1);
  for (int iteration = 0; iteration < 6; ++iteration) {
    if (points) *points += view.n;
    if (!landmark_step(w, view, *l, rho_sigma, pixel_sigma, scratch, step, &pivot, &cost)) return false;
    const S limit = S(0.5) * (absolute(l->rho) + S(0.2));
    if (step[2] > limit) step[2] = limit;
    if (step[2] < -limit) step[2] = -limit;
    add_step(l, step);
    if (last >= S(0) && absolute(last - cost) < S(1e-3) * pixel_sigma * pixel_sigma) break;
    last = cost;
  }
  if (sigma_rho) *sigma_rho = pixel_sigma / (pivot > S(1e-6) ? pivot : S(1e-6));
  // Slightly negative is noise about infinity; clearly negative is behind the camera.
  return is_finite(l->rho) && l->rho * pivot > S(-4) * pixel_sigma && l->rho < S(20);
}

/// Fits the landmark to its observations at the window's estimates. `scratch` holds 8 kWindow + 8 entries.
/// False: no convergence, behind a camera, closer than 5 cm. Optional: the inverse distance's sigma, poses exact; 1/m.
template <class S>
bool triangulate(const Window<S>& w, const TrackView<S>& view, S pixel_sigma, S* scratch, Landmark<S>* l,
                 S rho_sigma = kFilterDepthSigma<S>, S* sigma_rho = nullptr) {
  return guess_landmark(w, view, l) && refine_landmark(w, view, pixel_sigma, scratch, l, rho_sigma, sigma_rho);
}

/// The same with *rho for a first guess of the inverse distance, if it is not negative, and from the rays where that
/// leads nowhere; afterwards *rho serves the next time. `points`: as of refine_landmark().
template <class S>
bool triangulate_again(const Window<S>& w, const TrackView<S>& view, S pixel_sigma, S* scratch, Landmark<S>* l, S* rho,
                       std::int32_t* points) {
  const S carried = *rho;
  *rho = S(-1);
  bool good = false;
  for (int from_rays = carried < S(0) ? 1 : 0; from_rays < 2 && !good; ++from_rays) {
    const bool begun = from_rays ? guess_landmark(w, view, l) : ray_in_world(w, view, 0, &l->o, &l->m);
    if (begun && !from_rays) l->rho = carried;
    good = begun && refine_landmark<S>(w, view, pixel_sigma, scratch, l, kFilterDepthSigma<S>, nullptr, points);
  }
  if (good) *rho = l->rho > S(0) ? l->rho : S(0);
  return good;
}

}  // namespace SEGCAL_NS
