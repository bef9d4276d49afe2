// The start in motion, from tracks and inertial integrals: gyroscope bias, linear alignment,
// refinement, check, and the filter's window with all features. It is background work in slices
// (math/resumable.h) on the frames that the window holds; frames that come meanwhile do not
// touch window and tracks, so that what comes out does not depend on when the slices were done.
#pragma once

#include <new>

#include "math/resumable.h"
#include "vio/start_alignment.h"
#include "vio/start_gyro_bias.h"
#include "vio/vio_initialise.h"

namespace SEGCAL_NS {

/// s of IMU samples that a start may need.
constexpr double kStartSeconds = 1.4;
constexpr int kStartFrames = kWindow < 8 ? kWindow : 8;  // fewer frames than this are not tried
/// s; nor a shorter time, where the window has room for more frames: acceleration shows with its square.
constexpr double kShortestStart = 0.85;
/// More are not waited for: tracks must last as long.
constexpr int kMostStartFrames = kWindow < 20 ? kWindow : 20;

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
  /// Undoes what slices have moved that nobody has seen.
  [[gnu::noinline]] static void give_cameras_back(const StartContext<S>& c) {
    for (int i = 0; i < c.w->theta.n_cameras; ++i) c.w->theta.camera[i] = c.w->given.camera[i];
  }
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
      // None from before the one at the first frame: how many are left depends on when this is done.
      const int first = imu.at_or_before(first_ns_) - (had_before_ ? 1 : 0);
      pending_ = !run_step(c, ImuStretch<S>(imu, first, last_imu_ns_, warmth_));
    } else {
      pending_ = false;
    }
  }

 private:
  using Samples = ImuStretch<S>;
  [[gnu::cold]] bool run_step(const StartContext<S>& c, const Samples& imu);
  bool integrate_step(const StartContext<S>& c, const Samples& imu);
  void integrate_some(const Samples& imu, std::int64_t end);
  bool gyro_bias_step(const StartContext<S>& c, const Samples& imu);
  bool align_step(const StartContext<S>& c);
  bool linearise_step(const StartContext<S>& c);
  [[gnu::cold]] bool refine_step(const StartContext<S>& c);
  [[gnu::cold]] bool discard_step(const StartContext<S>& c);
  [[gnu::cold]] bool open_step(const StartContext<S>& c, const Samples& imu);
  [[gnu::cold]] bool use_tracks_step(const StartContext<S>& c);
  bool link_poses(const StartContext<S>& c);
  [[gnu::cold]] void begin_from_rest(const StartContext<S>& c);
  bool fold_some(Window<S>* w, S* rows, int m);
  bool unfold_some(Window<S>* w, S* rows, int m, int first);

  ImuIntegrator<S>* new_integrator(Window<S>* w) {
    static_assert(sizeof(ImuIntegrator<S>) <= sizeof(w->block), "the window's block is too small for an integrator");
    return integrator_ = new (w->block) ImuIntegrator<S>;
  }
  void correct(const StartContext<S>& c) {
    correct_links(c.w->n_poses, Vec3<S>(c.s->x0.b_a - base_.b_a), Vec3<S>(c.s->x0.b_g - base_.b_g), c.s->link.get());
  }
  PackedTriangle<S> triangle(const StartContext<S>& c) const {
    const int per_camera = with_lens_ ? kMaxCameraColumns : kExtrinsicColumns;
    return PackedTriangle<S>(c.w->triangle, kStateColumns + per_camera * c.w->theta.n_cameras + 1);
  }
  static void copy_cameras(const CameraCalibration<S>* from, int n, CameraCalibration<S>* to) {
    for (int i = 0; i < n; ++i) to[i] = from[i];
  }
  static constexpr int kSamplesPerSlice = 12,
                       kPointsPerSlice = 48;  ///< points: linearised, of two tracks as they usually are
  static constexpr int kFoldWork = 30000;     // products per slice, as fold_work() counts them
  bool pending_ = false, good_ = false, had_before_ = false;
  bool settled_ = false;    ///< the fit has come to its end
  bool with_lens_ = false;  ///< the fit moves it
  Place place_ = 0, inner_ = 0, leaf_ = 0;
  std::int32_t i_ = 0, k_ = 0, camera_ = 0, iteration_ = 0, column_ = 0, row_ = 0, rows_ = 0, used_ = 0, discarded_ = 0;
  std::int64_t first_ns_ = 0, last_imu_ns_ = 0, t_ = 0;
  S warmth_ = S(0), lambda_ = S(0);
  State<S> base_;  ///< biases that the links were integrated at
  Vec3<S> v0_, g_;
  S equations_[packed_size(7)];  ///< of the gyroscope's bias, then of the alignment
  RefineFit<S> fit_, trial_, aligned_;
  S rho_[kMaxVioTracks];  ///< inverse distances at the last linearisation, 1/m; negative: none
  Feature<S> feature_;
  Near<ImuIntegrator<S>> integrator_;  ///< in the window's block, which is free while samples are integrated
  SampleIntegration<S, std::int64_t> samples_;
};

template <class S>
bool MotionStart<S>::run_step(const StartContext<S>& c, const Samples& imu) {
  SEGCAL_SLICES(place_) {
    c.s->x0 = State<S>();
    c.s->still = false;
    c.s->lack = S(2);
    give_cameras_back(c);
    SEGCAL_AWAIT(place_, gyro_bias_step(c, imu));
    SEGCAL_AWAIT(place_, align_step(c));
    with_lens_ = false;
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
      with_lens_ = !good_ && c.options.sigma_focal > S(0);
      SEGCAL_PAUSE(place_);
      if (with_lens_) {
        SEGCAL_AWAIT(place_, refine_step(c));
        good_ = acceptable(c.w, fit_, triangle(c), c.s);
        SEGCAL_PAUSE(place_);
      }
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
    if (!good_ && c.s->lack < S(1)) c.s->lack = S(2);  // refused for something else
    if (!good_) give_cameras_back(c);
  }
  SEGCAL_SLICES_END(place_);
}

}  // namespace SEGCAL_NS

#include "vio/start_motion_align.h"
#include "vio/start_motion_fit.h"
#include "vio/start_motion_open.h"
