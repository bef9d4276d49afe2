// The filter's state and its square-root information.
//
// Columns of the triangle R: [v b_a b_g of the newest state 9 | poses, oldest first, 6 each | cameras 14 each
// (extrinsics, intrinsics) | IMU 15 (sensors/calibration.h) | right-hand side]. With this order everything that leaves
// the state stands at the front: the old motion when time moves on, and the oldest pose after a swap of the first 15
// rows. Places without a pose are zero rows and columns. R delta = d, where delta is the error of the estimates; after
// an update the estimates have moved and d is zero.
#pragma once

#include "math/one_of.h"
#include "math/packed_triangle.h"
#include "sensors/imu_link.h"
#include "vio/start_link.h"
#include "vio/vio_types.h"

namespace SEGCAL_NS {

constexpr int kWindow = SEGCAL_MAX_CLONES + 1;  // past poses and the newest
constexpr int kMotionColumns = 9;               // v, b_a, b_g
constexpr int kFilterColumns = kMotionColumns + kPoseColumns * kWindow + kMaxCameraColumns * kMaxCameras + kImuColumns;
constexpr int kLinkRows = 15;
// The scratch block holds the rows of one feature; or the leading rows of R, with room for the new motion, and as many
// of a link's rows as find room at a time.
constexpr int kBlockStride = kFilterColumns + 1 + kMotionColumns;
constexpr int kFeatureRows = 2 * kWindow + 1;  // the last one: what is known about distances
constexpr int kBlockRows = kFeatureRows > kLinkRows + 3 ? kFeatureRows : kLinkRows + 3;
constexpr int kRowsAtATime = kBlockRows - kMotionColumns < kLinkRows ? kBlockRows - kMotionColumns : kLinkRows;
// Between frames it has room for a triangle over theta and a right-hand side.
constexpr int kBlockSize = kBlockRows * kBlockStride > packed_size(kMaxTheta + 1) ? kBlockRows* kBlockStride
                                                                                  : packed_size(kMaxTheta + 1);

constexpr int pose_column(int i) { return kMotionColumns + kPoseColumns * i; }
constexpr int camera_column(int camera) { return pose_column(kWindow) + kMaxCameraColumns * camera; }
/// Column of entry i of the newest state's errors [theta p v b_a b_g], its pose being number `newest`.
constexpr int state_column(int i, int newest) { return i < kPoseColumns ? pose_column(newest) + i : i - kPoseColumns; }

template <class S>
struct WindowPose {
  Mat3<S> R_GI, R_first;  ///< estimate, and the first estimate: the place where Jacobians are taken
  Vec3<S> p_GI, p_first;  ///< m
  std::int64_t time;      ///< ns
  std::int32_t slot;      ///< place of its image points in each track
};

template <class S>
struct Window {
  Calibration<S> theta;                            ///< the filter's estimates
  Calibration<S> given;                            ///< as given from outside
  CameraCalibration<S> camera_first[kMaxCameras];  ///< theta's cameras at their first estimates
  WindowPose<S> pose[kWindow];
  State<S> now, now_first;  ///< newest state; its pose is that of newest()
  std::int32_t n_poses;
  S triangle[packed_size(kFilterColumns + 1)];
  alignas(8) S block[kBlockSize];
  bool learnt;              ///< R's rows of the sensors hold what earlier sessions told
  S pivot[kFilterColumns];  ///< diagonal of R before the last fold, to undo it
  struct StartLinks {
    StartLink<S> of_pose[kWindow];
  };
  OneOf<ImuRows<S>, StartLinks> links;  ///< the inertial link that is folded in; while there is none yet, the start's

  /// Whitened rows of the link that was linearised last.
  const ImuRows<S>& link() const { return links.template get<ImuRows<S>>(); }
  ImuRows<S>& link() { return links.template get<ImuRows<S>>(); }
  StartLink<S>* begin_start_links() { return links.template begin<StartLinks>().of_pose; }

  int imu_column() const { return camera_column(theta.n_cameras); }
  int columns() const { return imu_column() + kImuColumns; }
  PackedTriangle<S> R() { return PackedTriangle<S>(triangle, columns() + 1); }
  WindowPose<S>& newest() { return pose[n_poses - 1]; }
  const WindowPose<S>& newest() const { return pose[n_poses - 1]; }

  void reset(const Calibration<S>& calibration) {
    theta = given = calibration;
    learnt = false;
    clear();
  }

  /// No poses, no information but what was learnt in earlier
  /// sessions; the cameras' first estimates are the present ones.
  void clear() {
    n_poses = 0;
    clear_information();
    now = now_first = State<S>();
    for (int c = 0; c < theta.n_cameras; ++c) camera_first[c] = theta.camera[c];
  }

  /// The triangle is cleared. The sensors stand last: their own rows, which hold exactly their marginal information,
  /// stay where they were learnt in earlier sessions.
  void clear_information() {
    const int end = learnt ? packed_size(columns() + 1) - packed_size(columns() + 1 - camera_column(0))
                           : packed_size(columns() + 1);
    for (int i = 0; i < end; ++i) triangle[i] = S(0);
  }

  void replace_calibration(const Calibration<S>& calibration) {
    theta = given = calibration;
    learnt = false;
    for (int c = 0; c < theta.n_cameras; ++c) camera_first[c] = theta.camera[c];
  }

  /// What a lost filter has learnt about the sensors is not to be trusted.
  void restore_calibration() { replace_calibration(Calibration<S>(given)); }

  /// A pose at `time` without an estimate yet; returns its slot. There must be room.
  int append_empty(std::int64_t time) {
    std::uint32_t taken = 0;
    for (int i = 0; i < n_poses; ++i) taken |= 1u << pose[i].slot;
    int slot = 0;
    while (taken >> slot & 1u) ++slot;
    pose[n_poses].time = time;
    pose[n_poses].slot = slot;
    ++n_poses;
    return slot;
  }

  /// Places count from `by`, m, from now on.
  void move_origin(const Vec3<S>& by) {
    for (int i = 0; i < n_poses; ++i) {
      pose[i].p_GI -= by;
      pose[i].p_first -= by;
    }
    now.p_GI -= by;
    now_first.p_GI -= by;
  }

  /// Removes pose 0 from the list, not from R.
  void forget_oldest() {
    for (int i = 1; i < n_poses; ++i) pose[i - 1] = pose[i];
    --n_poses;
  }

  void clear_block(int rows) {
    for (int i = 0; i < rows * kBlockStride; ++i) block[i] = S(0);
  }
};

}  // namespace SEGCAL_NS
