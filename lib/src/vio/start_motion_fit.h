// Second part of the start in motion (start_motion.h): the alignment is refined with the cameras,
// judged, and rid of tracks that miss.
#pragma once

#include "math/small_solvers.h"
#include "vio/start_motion.h"

namespace SEGCAL_NS {

/// Standard deviation of entries [column, column + 3) of a triangle's solution, the largest.
template <class S>
S largest_sigma(const PackedTriangle<S>& R, int column, S* y) {
  S worst = S(0);
  for (int c = column; c < column + 3; ++c) {
    covariance_factor(R, R.columns() - 1, c, y);
    const S variance = factor_product<S>(y, y, R.columns() - 1);
    if (variance > worst) worst = variance;
  }
  return square_root(worst);
}

/// The speed is to be known to this share of itself. Of 0.05, 0.07 and 0.1 the one with the fewest bad starts in 160
/// simulated recordings (docs/results.md): a smaller one waits until the device has left the place where it moved well.
template <class S>
constexpr S kStartScale = S(0.07);
/// s. In a window of a second or less many motions never show their scale so well, and are not waited for forever:
/// after so long twice the share will do, and so on. At 4 s a few devices of profile mcu wait for more than 14 s. A
/// window of two seconds needs none of this, and a lens that is far off makes a wrong scale look known there.
template <class S>
constexpr S kStartPatience = S(2.5);
constexpr bool kShortWindow = kMostStartFrames < 20;
/// What a bound of 0.1 m/s comes to at the speed of a hand, 0.3 m/s.
template <class S>
constexpr S kMostStartScale = S(0.35);

template <class S>
S acceptable_scale_error(S waited_s) {
  if (!kShortWindow) return kStartScale<S>;
  const S share = kStartScale<S> * (S(1) + waited_s / kStartPatience<S>);
  return share < kMostStartScale<S> ? share : kMostStartScale<S>;
}

/// Is the fit one to fly with: most tracks agree, residuals are what pixel_sigma says, velocity and tilt are known?
/// In a wrong minimum (rotation with little parallax) many tracks miss by some pixel_sigma, and a window that has too
/// little to tell has large sigmas: both wait for better frames. Landmarks are as far off as the speed is, in shares,
/// and the filter linearises there: a scale that is off by more than a tenth it takes for known too well.
template <class S>
bool acceptable(Window<S>* w, const RefineFit<S>& fit, const PackedTriangle<S>& R, StartScratch<S>* s) {
  if (fit.tracks < 8 || fit.points < 60) return false;
  const S dof = S(2 * fit.points - 3 * fit.tracks);
  const S ratio = fit.cost / (dof > S(1) ? dof : S(1));
  s->pixel_scale = ratio < S(1) ? S(1) : square_root(ratio < S(16) ? ratio : S(16));
  s->lack = ratio / S(2.25);
  if (s->lack > S(1) || S(fit.good) < S(0.8) * S(fit.tried)) return false;
  const S speed = square_root(s->x0.v_GI.squaredNorm()), sigma_v = s->pixel_scale * largest_sigma(R, 6, w->block);
  const S most = acceptable_scale_error(s->waited) * speed;
  s->lack = most > S(0) ? sigma_v / most : S(2);
  return s->lack < S(1) && speed < S(6) && largest_sigma(R, 0, w->block) < S(0.05);
}

/// Linearises the window at x0 and the present cameras; trial_ is the fit there.
template <class S>
bool MotionStart<S>::linearise_step(const StartContext<S>& c) {
  PackedTriangle<S> R = triangle(c);
  SEGCAL_SLICES(leaf_) {
    correct(c);
    trial_ = begin_linearisation(c.w, c.options, *c.s, &R);
    SEGCAL_PAUSE(leaf_);
    for (k_ = 0; k_ < c.tracks->end(); ++k_) {
      if (!(*c.tracks)[k_].used) continue;
      refine_track(c.w, (*c.tracks)[k_], c.options, *c.s, &R, &trial_, &rho_[k_]);
      if (trial_.work < kPointsPerSlice) continue;
      trial_.work = 0;
      SEGCAL_PAUSE(leaf_);
    }
  }
  SEGCAL_SLICES_END(leaf_);
}

/// In a short window a start must be done within half a second, and its last frames come with it.
constexpr int kMostStartIterations = kShortWindow ? 8 : 12;

/// Minimises over x0 and the cameras; the best ones stay in x0 and the window, with R linearised there. settled_: the
/// last step changed the cost by less than 1e-3 of it.
template <class S>
bool MotionStart<S>::refine_step(const StartContext<S>& c) {
  const int cameras = c.w->theta.n_cameras;
  SEGCAL_SLICES(inner_) {
    for (S& rho : rho_) rho = S(-1);
    SEGCAL_AWAIT(inner_, linearise_step(c));
    fit_ = trial_;
    lambda_ = S(1e-3);
    settled_ = false;
    for (iteration_ = 0; iteration_ < kMostStartIterations; ++iteration_) {
      c.s->best = c.s->x0;
      copy_cameras(c.w->theta.camera, cameras, c.s->best_camera);
      descend(c.w, triangle(c), lambda_, c.s);
      SEGCAL_PAUSE(inner_);
      SEGCAL_AWAIT(inner_, linearise_step(c));
      if (trial_.cost < fit_.cost) {
        settled_ = fit_.cost - trial_.cost < S(1e-3) * fit_.cost;
        fit_ = trial_;
        lambda_ *= S(0.1);
        if (settled_) break;
        continue;
      }
      settled_ = trial_.cost - fit_.cost < S(1e-3) * fit_.cost;
      lambda_ *= S(10);
      c.s->x0 = c.s->best;
      copy_cameras(c.s->best_camera, cameras, c.w->theta.camera);
      SEGCAL_AWAIT(inner_, linearise_step(c));
      fit_ = trial_;
      if (settled_ || lambda_ > S(10)) break;
    }
  }
  SEGCAL_SLICES_END(inner_);
}

/// Keeps the aligned fit and begins anew without velocity.
template <class S>
void MotionStart<S>::begin_from_rest(const StartContext<S>& c) {
  aligned_ = fit_;
  c.s->aligned = c.s->x0;
  copy_cameras(c.w->theta.camera, c.w->theta.n_cameras, c.s->aligned_camera);
  give_cameras_back(c);
  c.s->x0.R_GI = c.origin.attitude(mean_gravity(*c.w, *c.s, square_root(c.options.g.squaredNorm())), c.options.g);
  c.s->x0.v_GI = c.s->x0.b_a = Vec3<S>::Zero();
}

template <class S>
bool MotionStart<S>::discard_step(const StartContext<S>& c) {
  SEGCAL_SLICES(inner_) {
    discarded_ = 0;
    for (k_ = 0; k_ < c.tracks->end(); ++k_) {
      if (misfit(c.w, (*c.tracks)[k_], c.options, c.s->pixel_scale)) {
        (*c.tracks)[k_].slots = 0;
        ++discarded_;
      }
      SEGCAL_PAUSE(inner_);
    }
  }
  SEGCAL_SLICES_END(inner_);
}

}  // namespace SEGCAL_NS
