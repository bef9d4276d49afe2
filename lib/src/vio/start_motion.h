// The start in motion, from tracks and inertial integrals: gyroscope bias, linear alignment, refinement, check, and the filter's
// window with all features. It is background work in slices (math/resumable.h) on the frames that the window holds; frames that
// come meanwhile do not touch window and tracks, so that what comes out does not depend on when the slices were done.
#pragma once

#include <new>

#include "math/resumable.h"
#include "vio/start_alignment.h"
#include "vio/start_gyro_bias.h"
#include "vio/vio_initialise.h"

namespace SEGCAL_NS {

constexpr int kStartFrames = kWindow < 8 ? kWindow : 8;  // fewer frames than this are not tried

/// What a start works on and for.
template <class S>
struct StartContext {
  Window<S>* w;
  TrackTable<S>* tracks;
  StartScratch<S>* s;
  const VioOptions<S>& options;
  const Origin<S>& origin;
  ResidualMonitor<S>* monitor;
  VioStatistics* statistics;
};

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

/// Is the fit one to fly with: most tracks agree, residuals are what pixel_sigma says, velocity and tilt are known?
/// In a wrong minimum (rotation with little parallax) many tracks miss by some pixel_sigma, and a window that has too
/// little to tell has large sigmas: both wait for better frames.
template <class S>
bool acceptable(Window<S>* w, const RefineFit<S>& fit, const PackedTriangle<S>& R, StartScratch<S>* s) {
  if (fit.tracks < 8 || fit.points < 60) return false;
  const S dof = S(2 * fit.points - 3 * fit.tracks);
  const S ratio = fit.cost / (dof > S(1) ? dof : S(1));
  s->pixel_scale = ratio < S(1) ? S(1) : square_root(ratio < S(16) ? ratio : S(16));
  if (ratio > S(2.25) || S(fit.good) < S(0.8) * S(fit.tried)) return false;
  return s->pixel_scale * largest_sigma(R, 6, w->block) < S(0.1) && largest_sigma(R, 0, w->block) < S(0.05) &&
         s->x0.v_GI.squaredNorm() < S(36);
}

template <class S>
class MotionStart {
 public:
  /// On the frames in the window as they are now.
  void begin(const Window<S>& w, const ImuHistory<S>& imu) {
    first_ns_ = w.pose[0].time;
    last_imu_ns_ = imu.newest();
    warmth_ = imu.warmth();
    had_before_ = imu.at_or_before(first_ns_) > 0;
    place_ = inner_ = leaf_ = 0;
    pending_ = true;
    good_ = false;
  }
  void cancel() { pending_ = false; }
  /// Slices are left.
  bool pending() const { return pending_; }
  /// When none are left: the filter's window is open.
  bool succeeded() const { return good_; }
  /// The samples are still there, and so will be after `more` others.
  bool keeps_samples(const ImuHistory<S>& imu, int more) const {
    if (!imu.covers(first_ns_, last_imu_ns_)) return false;
    const int before = imu.at_or_before(first_ns_), room = kImuHistory - imu.size();
    // The one before the first frame takes part where it did so in the beginning.
    return had_before_ ? before >= 1 && more <= room + before - 1 : more <= room + before;
  }

  /// One slice of it.
  void step(const StartContext<S>& c, const ImuHistory<S>& imu) {
    if (keeps_samples(imu, 0)) {
      pending_ = !run_step(c, ImuUntil<S>(imu, last_imu_ns_, warmth_));
    } else {
      pending_ = false;
    }
  }

 private:
  using Samples = ImuUntil<S>;
  bool run_step(const StartContext<S>& c, const Samples& imu);
  bool integrate_step(const StartContext<S>& c, const Samples& imu);
  void integrate_some(const Samples& imu, std::int64_t end);
  bool gyro_bias_step(const StartContext<S>& c, const Samples& imu);
  bool align_step(const StartContext<S>& c);
  bool linearise_step(const StartContext<S>& c);
  bool refine_step(const StartContext<S>& c);
  bool discard_step(const StartContext<S>& c);
  bool open_step(const StartContext<S>& c, const Samples& imu);
  bool use_tracks_step(const StartContext<S>& c);
  bool link_poses(const StartContext<S>& c);
  void begin_from_rest(const StartContext<S>& c);
  bool fold_some(Window<S>* w, S* rows, int m);
  bool unfold_some(Window<S>* w, S* rows, int m, int first);

  ImuIntegrator<S>* new_integrator(Window<S>* w) {
    static_assert(sizeof(ImuIntegrator<S>) <= sizeof(w->block), "the window's block is too small for an integrator");
    return integrator_ = new (w->block) ImuIntegrator<S>;
  }
  void correct(const StartContext<S>& c) {
    correct_links(c.w->n_poses, Vec3<S>(c.s->x0.b_a - base_.b_a), Vec3<S>(c.s->x0.b_g - base_.b_g), c.s->link);
  }
  static PackedTriangle<S> triangle(const StartContext<S>& c) {
    return PackedTriangle<S>(c.w->triangle, kStateColumns + kExtrinsicColumns * c.w->theta.n_cameras + 1);
  }
  static void copy_cameras(const CameraCalibration<S>* from, int n, CameraCalibration<S>* to) {
    for (int i = 0; i < n; ++i) to[i] = from[i];
  }
  static void give_cameras_back(const StartContext<S>& c) {
    for (int i = 0; i < c.w->theta.n_cameras; ++i) c.w->theta.camera[i] = c.w->given.camera[i];
  }

  static constexpr int kSamplesPerSlice = 12, kTracksPerSlice = 2;
  static constexpr int kFoldWork = 30000;  // products per slice, as fold_work() counts them
  bool pending_ = false, good_ = false, had_before_ = false, settled_ = false;
  Place place_ = 0, inner_ = 0, leaf_ = 0;
  std::int32_t i_ = 0, k_ = 0, camera_ = 0, iteration_ = 0, column_ = 0, row_ = 0, rows_ = 0, used_ = 0, discarded_ = 0;
  std::int64_t first_ns_ = 0, last_imu_ns_ = 0, t_ = 0;
  S warmth_ = S(0), lambda_ = S(0);
  State<S> base_;              ///< biases that the links were integrated at
  Vec3<S> v0_, g_;
  S equations_[packed_size(7)];   ///< of the gyroscope's bias, then of the alignment
  RefineFit<S> fit_, trial_, aligned_;
  S rho_[kMaxVioTracks];       ///< inverse distances at the last linearisation, 1/m; negative: none
  Feature<S> feature_;
  ImuIntegrator<S>* integrator_ = nullptr;   ///< in the window's block, which is free while samples are integrated
  SampleIntegration<S, std::int64_t> samples_;
};

template <class S>
bool MotionStart<S>::run_step(const StartContext<S>& c, const Samples& imu) {
  SEGCAL_SLICES(place_) {
    c.s->x0 = State<S>();
    c.s->still = false;
    give_cameras_back(c);
    SEGCAL_AWAIT(place_, gyro_bias_step(c, imu));
    SEGCAL_AWAIT(place_, align_step(c));
    if (good_) {
      SEGCAL_AWAIT(place_, refine_step(c));
      // The linear alignment may end near a wrong minimum if the device turns more than it moves. Hands move slowly:
      // descends once more, from zero velocity, and keeps the better of the two fits.
      begin_from_rest(c);
      SEGCAL_AWAIT(place_, refine_step(c));
      if (!(fit_.cost < aligned_.cost)) {
        c.s->x0 = c.s->aligned;
        copy_cameras(c.s->aligned_camera, c.w->theta.n_cameras, c.w->theta.camera);
        SEGCAL_AWAIT(place_, linearise_step(c));
        fit_ = trial_;
      }
      good_ = acceptable(c.w, fit_, triangle(c), c.s);
      SEGCAL_PAUSE(place_);
    }
    if (good_) {
      SEGCAL_AWAIT(place_, discard_step(c));
      if (discarded_ > 0) {
        SEGCAL_AWAIT(place_, refine_step(c));
        good_ = acceptable(c.w, fit_, triangle(c), c.s);
      }
      SEGCAL_PAUSE(place_);
    }
    if (good_) SEGCAL_AWAIT(place_, open_step(c, imu));
    if (good_) SEGCAL_AWAIT(place_, use_tracks_step(c));
    if (!good_) give_cameras_back(c);
  }
  SEGCAL_SLICES_END(place_);
}

/// Integrates once over the whole window at x0's biases and keeps the integral at each frame.
template <class S>
bool MotionStart<S>::integrate_step(const StartContext<S>& c, const Samples& imu) {
  SEGCAL_SLICES(leaf_) {
    base_ = c.s->x0;
    new_integrator(c.w)->begin(c.w->theta.imu, base_.b_a, base_.b_g, c.options.noise);
    t_ = c.w->pose[0].time;
    integrator_->start(reading_at<S>(imu, t_));
    copy_link(integrator_->result(), &c.s->link[0]);
    for (i_ = 1; i_ < c.w->n_poses; ++i_) {
      while (t_ < c.w->pose[i_].time) {
        integrate_some(imu, c.w->pose[i_].time);
        SEGCAL_PAUSE(leaf_);
      }
      copy_link(integrator_->result(), &c.s->link[i_]);
    }
  }
  SEGCAL_SLICES_END(leaf_);
}

template <class S>
void MotionStart<S>::integrate_some(const Samples& imu, std::int64_t end) {
  int k = imu.at_or_before(t_) + 1;
  for (int left = kSamplesPerSlice; left > 0; --left, ++k) {
    const bool between = k < imu.size() && imu.time(k) < end;
    const std::int64_t to = between ? imu.time(k) : end;
    integrator_->step(between ? imu.reading(k) : reading_at<S>(imu, end), S(to - t_) * S(1e-9));
    t_ = to;
    if (!between) return;
  }
}

/// Improves x0's gyroscope bias; the links follow it to first order, and are integrated anew at the end.
template <class S>
bool MotionStart<S>::gyro_bias_step(const StartContext<S>& c, const Samples& imu) {
  PackedTriangle<S> total(equations_, 4);
  SEGCAL_SLICES(inner_) {
    SEGCAL_AWAIT(inner_, integrate_step(c, imu));
    for (iteration_ = 0; iteration_ < 4; ++iteration_) {
      begin_gyro_bias(c.options, *c.s, &total);
      for (camera_ = 0; camera_ < c.w->theta.n_cameras; ++camera_) {
        for (k_ = 0; k_ + 2 < c.w->n_poses; ++k_) {
          fold_pair(*c.w, *c.tracks, *c.s, camera_, k_, k_ + 2,
                    S(1.5) * c.options.pixel_sigma / c.w->theta.camera[camera_].intrinsics(0), &total);
          SEGCAL_PAUSE(inner_);
        }
      }
      solve_gyro_bias(total, c.s);
      correct(c);
    }
    SEGCAL_AWAIT(inner_, integrate_step(c, imu));
  }
  SEGCAL_SLICES_END(inner_);
}

/// Velocity and attitude of x0 from the tracks; good_ is false if there are too few of them.
template <class S>
bool MotionStart<S>::align_step(const StartContext<S>& c) {
  const S magnitude = square_root(c.options.g.squaredNorm());
  PackedTriangle<S> R(equations_, 7);
  SEGCAL_SLICES(inner_) {
    g_ = mean_gravity(*c.w, *c.s, magnitude);
    v0_ = Vec3<S>::Zero();
    good_ = true;
    for (iteration_ = 0; iteration_ < 5 && good_; ++iteration_) {
      R.clear();
      used_ = 0;
      for (k_ = 0; k_ < c.tracks->end(); ++k_) {
        if (!(*c.tracks)[k_].used) continue;
        used_ += fold_alignment_track(c.w, *c.s, (*c.tracks)[k_], iteration_ > 0, v0_, g_, alignment_sigma(*c.w, c.options), &R) ? 1 : 0;
        SEGCAL_PAUSE(inner_);
      }
      good_ = used_ >= 6 && solve_alignment(R, magnitude, &v0_, &g_);
    }
    if (good_) {
      c.s->x0.R_GI = c.origin.attitude(g_, c.options.g);
      c.s->x0.v_GI = c.s->x0.R_GI * v0_;
      c.s->x0.p_GI = c.origin.p_GI;
    }
  }
  SEGCAL_SLICES_END(inner_);
}

/// Linearises the window at x0 and the present extrinsics; trial_ is the fit there.
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
      if (k_ % kTracksPerSlice == 0) SEGCAL_PAUSE(leaf_);
    }
  }
  SEGCAL_SLICES_END(leaf_);
}

/// Minimises over x0 and the extrinsics; the best ones stay in x0 and the window, with R linearised there.
template <class S>
bool MotionStart<S>::refine_step(const StartContext<S>& c) {
  const int cameras = c.w->theta.n_cameras;
  SEGCAL_SLICES(inner_) {
    for (S& rho : rho_) rho = S(-1);
    SEGCAL_AWAIT(inner_, linearise_step(c));
    fit_ = trial_;
    lambda_ = S(1e-3);
    for (iteration_ = 0; iteration_ < 8; ++iteration_) {
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
      lambda_ *= S(10);
      c.s->x0 = c.s->best;
      copy_cameras(c.s->best_camera, cameras, c.w->theta.camera);
      SEGCAL_AWAIT(inner_, linearise_step(c));
      fit_ = trial_;
      if (lambda_ > S(10)) break;
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

/// The prior of the first state, then its information through the window by the inertial links. good_ is false if a link has
/// no duration.
template <class S>
bool MotionStart<S>::open_step(const StartContext<S>& c, const Samples& imu) {
  SEGCAL_SLICES(inner_) {
    begin_window(c.w, c.options, c.s->x0, S(3));
    SEGCAL_PAUSE(inner_);
    for (i_ = 1; i_ < c.w->n_poses && good_; ++i_) {
      new_integrator(c.w)->begin(c.w->theta.imu, c.w->now.b_a, c.w->now.b_g,
                                 noise_in(imu, c.options.noise, c.w->pose[i_ - 1].time, c.w->pose[i_].time), &c.w->theta.effects);
      samples_.restart();
      SEGCAL_AWAIT(inner_, samples_.step(imu, c.w->pose[i_ - 1].time, c.w->pose[i_].time, S(1e-9), integrator_,
                                         stretch_between(c.w->pose[i_ - 1].time, c.w->pose[i_].time, imu.warmth, *integrator_)));
      SEGCAL_PAUSE(inner_);
      good_ = link_poses(c);
      for (row_ = 0; good_ && row_ < kLinkRows; row_ += rows_) {
        SEGCAL_PAUSE(inner_);
        rows_ = reduce_link(c.w, row_, i_ - 1, i_);
        SEGCAL_PAUSE(inner_);
        for (column_ = 0; !fold_some(c.w, link_rows_in(c.w), rows_);) SEGCAL_PAUSE(inner_);
      }
    }
  }
  SEGCAL_SLICES_END(inner_);
}

/// Linearises link i_; the old motion goes into the block, and the link's second pose is placed.
template <class S>
bool MotionStart<S>::link_poses(const StartContext<S>& c) {
  Window<S>* w = c.w;
  const ImuIntegral<S>& I = integrator_->result();
  const State<S> x1 = predicted(I, w->now, c.options.g);
  if (!linearise_link(w, c.options, I, x1, x1)) return false;
  w->link.r.setZero();
  stack_motion(w);
  w->pose[i_].R_GI = w->pose[i_].R_first = x1.R_GI;
  w->pose[i_].p_GI = w->pose[i_].p_first = x1.p_GI;
  w->now = w->now_first = x1;
  return true;
}

/// All features, when the window is all there is, and the update.
template <class S>
bool MotionStart<S>::use_tracks_step(const StartContext<S>& c) {
  Window<S>* w = c.w;
  SEGCAL_SLICES(inner_) {
    *c.monitor = ResidualMonitor<S>();
    c.monitor->scale = c.s->pixel_scale;
    used_ = 0;
    for (k_ = 0; k_ < c.tracks->end(); ++k_) {
      if (!(*c.tracks)[k_].used) continue;
      if ((*c.tracks)[k_].length() >= kMinTrackLength) {
        if (prepare_feature(w, (*c.tracks)[k_], c.options, c.monitor, c.statistics, &feature_)) {
          SEGCAL_PAUSE(inner_);
          for (column_ = feature_.first; !fold_some(w, feature_rest(w), feature_.dof);) SEGCAL_PAUSE(inner_);
          if (passes_gate(feature_, left_over(w, feature_rest(w), feature_.dof), c.monitor, c.statistics)) {
            ++used_;
          } else {
            SEGCAL_PAUSE(inner_);
            for (column_ = w->columns(); !unfold_some(w, feature_rest(w), feature_.dof, feature_.first);) SEGCAL_PAUSE(inner_);
          }
        }
        (*c.tracks)[k_].slots = 0;
        SEGCAL_PAUSE(inner_);
      }
      if (!(*c.tracks)[k_].alive) (*c.tracks)[k_].used = false;
    }
    if (used_ > 0) apply_update(w);
    SEGCAL_PAUSE(inner_);
    if (w->n_poses == kWindow) {
      c.tracks->forget_slot(w->pose[0].slot);
      drop_oldest(w);
    }
  }
  SEGCAL_SLICES_END(inner_);
}

/// Goes on with a fold of m rows from column_ on; true when it is done.
template <class S>
bool MotionStart<S>::fold_some(Window<S>* w, S* rows, int m) {
  const int n = w->columns();
  int until = column_;
  for (int work = 0; until < n && work < kFoldWork; ++until) work += m * (n + 1 - until);
  fold_columns(w, rows, m, column_, until);
  column_ = until;
  return until == n;
}

/// The same for taking one back, from column_ down to `first`.
template <class S>
bool MotionStart<S>::unfold_some(Window<S>* w, S* rows, int m, int first) {
  int from = column_;
  for (int work = 0; from > first && work < kFoldWork; --from) work += m * (w->columns() + 1 - from);
  unfold_columns(w, rows, m, from, column_);
  column_ = from;
  return from == first;
}

}  // namespace SEGCAL_NS
