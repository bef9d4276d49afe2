// What goes into the filter and what comes out: options, image points, status, statistics.
#pragma once

#include <cstdint>

#include "segments/landmark.h"
#include "sensors/imu_history.h"
#include "sensors/track_point.h"

namespace SEGCAL_NS {

/// All sigmas are one standard deviation.
template <class S>
struct VioOptions {
  ImuNoise<S> noise;
  S pixel_sigma = S(1);                ///< px; above the tracker's 0.5: it also pays for linearisation
  S track_walk = S(0);                 ///< px/sqrt(s); random walk of a corner along its track, beside pixel_sigma
  Vec3<S> g{S(0), S(0), S(-9.80665)};  ///< gravity in G; m/s^2
  S frame_interval_s = S(0.1);         ///< frames closer than this to the last one used are skipped
  S sigma_r_CI = S(0.05);              ///< rad; extrinsic rotation before any calibration
  S sigma_p_CI = S(0.03);              ///< m
  S sigma_focal = S(0.04);             ///< share of f; 0: the intrinsics are taken as exact
  S sigma_centre = S(10);              ///< px
  S sigma_distortion = S(0.05);        ///< of each coefficient
  S sigma_gyro = S(0.01);              ///< gyroscope scale and misalignment; 0: taken as exact
  S sigma_accel = S(0.02);             ///< accelerometer scale and misalignment; 0: taken as exact
  S sigma_r_AI = S(0.02);              ///< rad; accelerometer rotation; 0: taken as exact
  S sigma_b_a = S(0.2);                ///< m/s^2; bias of an unknown device
  S sigma_b_g = S(0.1);                ///< rad/s
  S still_velocity_sigma = S(0.005);   ///< m/s; what "stands still" may hide
  S still_pixels = S(0.4);             ///< px; common motion of the tracks below which the camera may stand still
  S still_metres = S(0.0025);          ///< m; what a thing that rocks in place may move, and its sigma
  S still_accel = S(0.1);              ///< m/s^2; standard deviation of the accelerometer at rest, at most
  S still_gyro = S(0.012);             ///< rad/s; the same for the gyroscope
  S max_speed = S(10);                 ///< m/s; faster: the filter has diverged
  S max_gap_s = S(0.6);                ///< s between processed frames; longer: start again
  S max_blind_s = S(2);                ///< s without a usable feature; longer: start again
  /// a start that is due and not done: its frame does the rest; else it waits for its slices
  bool late_start_at_once = true;

  /// Variance of the walk in units of the white noise's, 1/s. Where residuals ask for a larger pixel_sigma
  /// (ResidualMonitor), the walk grows with it: both are one covariance.
  S walk_variance() const { return track_walk * track_walk / (pixel_sigma * pixel_sigma); }
  /// Multiplies the sigmas of the calibration: a small share makes the filter run with what it is given.
  void share_calibration(S share) {
    sigma_r_CI *= share;
    sigma_p_CI *= share;
    sigma_focal *= share;
    sigma_centre *= share;
    sigma_distortion *= share;
    sigma_gyro *= share;
    sigma_accel *= share;
    sigma_r_AI *= share;
  }
};

enum class VioStatus : std::int32_t {
  waiting,       ///< IMU samples do not reach the frame yet: push the frame again later
  initialising,  ///< the frame was taken, there is no state yet
  tracking,      ///< state() is at this frame
  skipped,       ///< closer than frame_interval_s to the last one used, or not newer
  lost           ///< the filter gave up at this frame and starts again
};

/// Counters since reset().
struct VioStatistics {
  std::int32_t frames = 0;            ///< processed, without the skipped ones
  std::int32_t updates = 0;           ///< features used
  std::int32_t gated = 0;             ///< features refused by the Mahalanobis gate
  std::int32_t not_triangulated = 0;  ///< behind the camera, no convergence
  std::int32_t dropped_points = 0;    ///< no room in the track table
  std::int32_t standstill_frames = 0;
  // since the filter ran last:
  std::int32_t frames_waited = 0;  ///< collected for a start
  std::int32_t starts_tried = 0;   ///< in motion, with the frames at which another was not worth a try yet
  // since reset(), over sessions:
  std::int32_t starts = 0;       ///< successful initialisations
  std::int32_t late_starts = 0;  ///< frames at which a start was due and its slices were not done
  std::int32_t restarts = 0;     ///< times the filter was lost
};

}  // namespace SEGCAL_NS
