// A landmark from one track and the window's poses: two bearings for a first guess, Gauss-Newton on the pixels after.
#pragma once

#include "math/small_solvers.h"
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

/// Place of the camera in G and the unit direction of an image point in G.
template <class S>
bool ray_in_world(const Window<S>& w, const TrackView<S>& view, int i, Vec3<S>* o, Vec3<S>* m) {
  const CameraCalibration<S>& camera = w.theta.camera[view.track->camera];
  const WindowPose<S>& pose = w.pose[view.pose[i]];
  Vec2<S> xy;
  if (!unproject(camera, view.uv(w, i), &xy)) return false;
  const Vec3<S> h_C(xy.x(), xy.y(), S(1));
  const Mat3<S> R_GC = pose.R_GI * camera.R_CI.transpose();
  *o = pose.p_GI - R_GC * camera.p_CI;
  *m = R_GC * (h_C / square_root(h_C.squaredNorm()));
  return true;
}

/// First guess: direction of the first ray, inverse distance from all others by least squares.
/// A ray m from o' sees l = o + m0 / rho: m x (m0 + rho (o - o')) = 0, linear in rho.
template <class S>
bool guess_landmark(const Window<S>& w, const TrackView<S>& view, Landmark<S>* l) {
  if (!ray_in_world(w, view, 0, &l->o, &l->m)) return false;
  S above = S(0), below = S(0);
  for (int i = 1; i < view.n; ++i) {
    Vec3<S> o, m;
    if (!ray_in_world(w, view, i, &o, &m)) continue;
    const Vec3<S> a = cross<S>(m, l->m), b = cross<S>(m, Vec3<S>(l->o - o));
    above -= a.dot(b);
    below += b.dot(b);
  }
  l->rho = below > S(1e-10) ? above / below : S(0);
  if (l->rho < S(0)) l->rho = S(0);
  if (l->rho > S(5)) l->rho = S(5);
  return true;
}

/// Landmarks are taken to be some metres away, or anywhere beyond: inverse distance 0 with this sigma, 1/m. It hardly
/// touches a landmark with parallax; without parallax it keeps the noise of the points from becoming a near landmark,
/// which would then seem to tell about the camera's translation. But hundreds of near landmarks that all want to be
/// farther away stretch the path, by millimetres at half a metre: where the place is known anyway (standstill.h), the
/// second sigma is taken.
template <class S>
constexpr S kInverseDistanceSigma = S(5);
template <class S>
constexpr S kHeldDistanceSigma = S(50);

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

/// Gauss-Newton from *l. Optional: the inverse distance's sigma, and `points`, to which those that were linearised are added.
template <class S>
bool refine_landmark(const Window<S>& w, const TrackView<S>& view, S pixel_sigma, S* scratch, Landmark<S>* l,
                     S rho_sigma = kInverseDistanceSigma<S>, S* sigma_rho = nullptr, std::int32_t* points = nullptr) {
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
                 S rho_sigma = kInverseDistanceSigma<S>, S* sigma_rho = nullptr) {
  return guess_landmark(w, view, l) && refine_landmark(w, view, pixel_sigma, scratch, l, rho_sigma, sigma_rho);
}

/// The same with *rho for a first guess of the inverse distance, if it is not negative; afterwards *rho serves the next time. `points`: as
/// of refine_landmark().
template <class S>
bool triangulate_again(const Window<S>& w, const TrackView<S>& view, S pixel_sigma, S* scratch, Landmark<S>* l, S* rho,
                       std::int32_t* points) {
  const S guess = *rho;
  *rho = S(-1);
  if (!(guess < S(0)) ? !ray_in_world(w, view, 0, &l->o, &l->m) : !guess_landmark(w, view, l)) return false;
  if (!(guess < S(0))) l->rho = guess;
  if (!refine_landmark<S>(w, view, pixel_sigma, scratch, l, kInverseDistanceSigma<S>, nullptr, points)) return false;
  *rho = l->rho > S(0) ? l->rho : S(0);
  return true;
}

}  // namespace SEGCAL_NS
