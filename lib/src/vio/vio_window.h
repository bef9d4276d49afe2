// The filter's state and its square-root information.
//
// Columns of the triangle R: [v b_a b_g of the newest state 9 | poses, oldest first, 6 each | cameras 14 each
// (extrinsics, intrinsics) | IMU 15 (sensors/calibration.h) | right-hand side]. With this order everything that leaves
// the state stands at the front: the old motion when time moves on, and the oldest pose after a swap of the first 15
// rows. Places without a pose are zero rows and columns. R delta = d, where delta is the error of the estimates; after
// an update the estimates have moved and d is zero.
#pragma once

#include "math/qr.h"
#include "sensors/imu_link.h"
#include "vio/vio_types.h"

namespace SEGCAL_NS {

constexpr int kWindow = SEGCAL_MAX_CLONES + 1;  // past poses and the newest
constexpr int kMotionColumns = 9;               // v, b_a, b_g
constexpr int kFilterColumns = kMotionColumns + kPoseColumns * kWindow + kMaxCameraColumns * kMaxCameras + kImuColumns;
constexpr int kLinkRows = 15;
constexpr int kStartLinkNumbers = 76;           // start_links.h
// The scratch block holds the rows of one feature; or the leading rows of R, with room for the new motion, and as many of a
// link's rows as find room at a time.
constexpr int kBlockStride = kFilterColumns + 1 + kMotionColumns;
constexpr int kFeatureRows = 2 * kWindow + 1;  // the last one: what is known about distances
constexpr int kBlockRows = kFeatureRows > kLinkRows + 3 ? kFeatureRows : kLinkRows + 3;
constexpr int kRowsAtATime = kBlockRows - kMotionColumns < kLinkRows ? kBlockRows - kMotionColumns : kLinkRows;
// Between frames it is lent for a triangle over theta and a right-hand side.
constexpr int kBlockSize =
    kBlockRows * kBlockStride > packed_size(kMaxTheta + 1) ? kBlockRows * kBlockStride : packed_size(kMaxTheta + 1);

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
  Calibration<S> theta;              ///< the filter's estimates
  Calibration<S> given;              ///< as given from outside
  CameraCalibration<S> camera_first[kMaxCameras];  ///< theta's cameras at their first estimates
  WindowPose<S> pose[kWindow];
  State<S> now, now_first;           ///< newest state; its pose is that of newest()
  std::int32_t n_poses;
  S triangle[packed_size(kFilterColumns + 1)];
  alignas(8) S block[kBlockSize];
  S work[kBlockStride];
  bool learnt;                       ///< R's rows of the sensors hold what earlier sessions told
  S pivot[kFilterColumns];           ///< diagonal of R before the last fold, to undo it
  /// The inertial link that is folded in; before that, while there are no links yet, the start's.
  union {
    ImuRows<S> link;
    S start_links[kStartLinkNumbers * kWindow];
  };

  Window() {}

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

  /// No poses, no information but what was learnt in earlier sessions; the cameras' first estimates are the present ones.
  void clear() {
    n_poses = 0;
    clear_information();
    now = now_first = State<S>();
    for (int c = 0; c < theta.n_cameras; ++c) camera_first[c] = theta.camera[c];
  }

  /// The triangle is cleared. The sensors stand last: their own rows, which hold exactly their marginal information, stay
  /// where they were learnt in earlier sessions.
  void clear_information() {
    const int end = learnt ? packed_size(columns() + 1) - packed_size(columns() + 1 - camera_column(0)) : packed_size(columns() + 1);
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

/// Upper 1 % point of chi-square (Wilson and Hilferty).
template <class S>
S chi_square_gate(int dof) {
  const S k = S(2) / (S(9) * S(dof));
  const S root = S(1) - k + S(2.326) * square_root(k);
  return S(dof) * root * root * root;
}

/// Folds `rows` rows of the block (absolute columns, zero before `first`) into R.
/// Returns the squared norm of what R cannot absorb: the innovation's Mahalanobis distance if d was zero.
template <class S>
S fold_block(Window<S>* w, S* rows, int n_rows, int first) {
  const int n = w->columns();
  fold_columns(w, rows, n_rows, first, n);
  return left_over(w, rows, n_rows);
}

/// Squared norm of what R did not absorb of the rows.
template <class S>
S left_over(const Window<S>* w, const S* rows, int n_rows) {
  const int n = w->columns();
  S rest = S(0);
  for (int i = 0; i < n_rows; ++i) rest += rows[i * kBlockStride + n] * rows[i * kBlockStride + n];
  return rest;
}

/// The fold's part of columns [first, last).
template <class S>
void fold_columns(Window<S>* w, S* rows, int n_rows, int first, int last) {
  PackedTriangle<S> R = w->R();
  for (int j = first; j < last; ++j) w->pivot[j] = R(j, j);
  fold_rows(R, rows, n_rows, kBlockStride, first, last);
}

/// Takes the last fold_block() back: the same reflections in reverse order, each its own inverse (up to rounding).
/// Their vectors are still there: reflect_column() leaves the column that it clears in the block, and `pivot` has the rest.
template <class S>
void unfold_block(Window<S>* w, S* rows, int n_rows, int first) {
  unfold_columns(w, rows, n_rows, first, w->columns());
}

/// Of columns [first, last), the last first.
template <class S>
void unfold_columns(Window<S>* w, S* rows, int n_rows, int first, int last) {
  PackedTriangle<S> R = w->R();
  for (int j = last - 1; j >= first; --j) {
    S* r = R.row(j);
    S below = S(0);
    for (int i = 0; i < n_rows; ++i) below += rows[i * kBlockStride + j] * rows[i * kBlockStride + j];
    if (below < smallest_square<S>) continue;
    const S v0 = w->pivot[j] - r[j], scale = S(-1) / (r[j] * v0);
    for (int c = j + 1; c < R.columns(); ++c) w->work[c] = v0 * r[c];
    for (int i = 0; i < n_rows; ++i) {
      add_scaled(w->work, rows[i * kBlockStride + j], rows + i * kBlockStride, j + 1, R.columns());
    }
    for (int c = j + 1; c < R.columns(); ++c) w->work[c] *= scale;
    add_scaled(r, -v0, w->work, j + 1, R.columns());
    for (int i = 0; i < n_rows; ++i) {
      add_scaled(rows + i * kBlockStride, -rows[i * kBlockStride + j], w->work, j + 1, R.columns());
    }
    r[j] = w->pivot[j];
  }
}

/// Moves all estimates by R^-1 d; afterwards d is zero. First estimates stay.
template <class S>
void apply_update(Window<S>* w) {
  PackedTriangle<S> R = w->R();
  const int n = w->columns();
  S* d = w->block;
  for (int j = 0; j < n; ++j) {
    d[j] = R(j, n);
    R.row(j)[n] = S(0);
  }
  R.row(n)[n] = S(0);
  back_substitute(R, n, d);
  const auto three = [d](int c) { return Vec3<S>(d[c], d[c + 1], d[c + 2]); };
  for (int i = 0; i < w->n_poses; ++i) {
    WindowPose<S>& pose = w->pose[i];
    pose.R_GI = renormalised<S>(pose.R_GI * so3_exp<S>(three(pose_column(i))));
    pose.p_GI += three(pose_column(i) + 3);
  }
  w->now.R_GI = w->newest().R_GI;
  w->now.p_GI = w->newest().p_GI;
  w->now.v_GI += three(0);
  w->now.b_a += three(3);
  w->now.b_g += three(6);
  for (int c = 0; c < w->theta.n_cameras; ++c) {
    CameraCalibration<S>& camera = w->theta.camera[c];
    camera.R_CI = renormalised<S>(so3_exp<S>(three(camera_column(c))) * camera.R_CI);
    camera.p_CI += three(camera_column(c) + 3);
    for (int i = 0; i < 4; ++i) camera.intrinsics(i) += d[camera_column(c) + kExtrinsicColumns + i];
    for (int i = 0; i < 4; ++i) camera.distortion(i) += d[camera_column(c) + kExtrinsicColumns + 4 + i];
  }
  ImuCalibration<S>& imu = w->theta.imu;
  const int first = w->imu_column();
  imu.gyro_scale += three(first);
  imu.gyro_misalignment += three(first + 3);
  imu.accel_scale += three(first + 6);
  imu.accel_misalignment += three(first + 9);
  imu.R_AI = renormalised<S>(so3_exp<S>(three(first + 12)) * imu.R_AI);
}

/// y <- R^-T y (n columns), y zero before `first`.
template <class S>
void forward_substitute(const PackedTriangle<S>& R, int n, int first, S* y) {
  for (int j = first; j < n; ++j) {
    const S* r = R.row(j);
    y[j] = r[j] == S(0) ? S(0) : y[j] / r[j];
    add_scaled(y, -y[j], r, j + 1, n);
  }
}

/// y = R^-T e_column (n columns): the dot products of such vectors are the entries of the covariance R^-1 R^-T.
template <class S>
void covariance_factor(const PackedTriangle<S>& R, int n, int column, S* y) {
  for (int j = 0; j < n; ++j) y[j] = S(0);
  y[column] = S(1);
  forward_substitute(R, n, column, y);
}

template <class S>
S factor_product(const S* a, const S* b, int n) {
  S sum = S(0);
  for (int i = 0; i < n; ++i) sum += a[i] * b[i];
  return sum;
}

/// Covariance of the newest state. Uses the scratch block.
template <class S>
void state_covariance(Window<S>* w, Mat<S, kStateColumns, kStateColumns>* P) {
  for (int i = 0; i < kStateColumns; ++i) {
    covariance_factor(w->R(), w->columns(), state_column(i, w->n_poses - 1), w->block + i * kBlockStride);
    for (int j = 0; j <= i; ++j) {
      (*P)(i, j) = factor_product(w->block + i * kBlockStride, w->block + j * kBlockStride, w->columns());
      (*P)(j, i) = (*P)(i, j);
    }
  }
}

/// The sensors' marginal information as a triangle over theta's columns and a right-hand side of zero: the filter's estimates
/// are its solution. Lenses with one coefficient leave places of the filter empty. About terms of effects the filter learns
/// nothing: their rows stay zero.
template <class S>
void sensor_triangle(Window<S>* w, PackedTriangle<S>* out) {
  std::int32_t from[kMaxTheta];
  int n = 0;
  for (int c = 0; c < w->theta.n_cameras; ++c) {
    for (int i = 0; i < w->theta.camera[c].columns(); ++i) from[n++] = camera_column(c) + i;
  }
  for (int i = 0; i < kImuColumns; ++i) from[n++] = w->imu_column() + i;
  out->clear();
  for (int j = 0; j < n; ++j) {
    for (int c = j; c < n; ++c) out->row(j)[c] = w->R()(from[j], from[c]);
  }
}

template <class S>
void extrinsics_sigma(Window<S>* w, int camera, Vec<S, kExtrinsicColumns>* sigma) {
  for (int i = 0; i < kExtrinsicColumns; ++i) {
    covariance_factor(w->R(), w->columns(), camera_column(camera) + i, w->block);
    (*sigma)(i) = square_root(factor_product<S>(w->block, w->block, w->columns()));
  }
}

/// Prior sigma of column i of camera c; 0: the column is not estimated.
template <class S>
S camera_sigma(const VioOptions<S>& options, const CameraCalibration<S>& camera, int i) {
  if (i < 3) return options.sigma_r_CI;
  if (i < kExtrinsicColumns) return options.sigma_p_CI;
  if (options.sigma_focal == S(0) || i >= camera.columns()) return S(0);
  if (i < kExtrinsicColumns + 2) return options.sigma_focal * camera.intrinsics(0);
  return i < kExtrinsicColumns + 4 ? options.sigma_centre : options.sigma_distortion;
}

/// Prior sigma of entry i of the IMU's calibration; 0: it is not estimated.
template <class S>
S imu_sigma(const VioOptions<S>& options, int i) {
  return i < 6 ? options.sigma_gyro : i < 12 ? options.sigma_accel : options.sigma_r_AI;
}

/// The kept information on the sensors as a prior at `given`, seen from the present theta (the start moves the extrinsics).
template <class S>
void fold_learnt(Window<S>* w) {
  PackedTriangle<S> R = w->R();
  const int n = w->columns();
  S* offset = w->block;
  for (int j = 0; j < n; ++j) offset[j] = S(0);
  for (int c = 0; c < w->theta.n_cameras; ++c) {
    const CameraCalibration<S>&now = w->theta.camera[c], &given = w->given.camera[c];
    const Vec3<S> r = so3_log<S>(given.R_CI * now.R_CI.transpose()), dp = given.p_CI - now.p_CI;
    for (int i = 0; i < 3; ++i) {
      offset[camera_column(c) + i] = r(i);
      offset[camera_column(c) + 3 + i] = dp(i);
    }
  }
  for (int j = camera_column(0); j < n; ++j) {
    S sum = S(0);
    for (int c = j; c < n; ++c) sum += R(j, c) * offset[c];
    R.row(j)[n] = sum;
  }
}

/// What was learnt about the sensors is replaced by a prior at their new values; the poses, given the sensors, are
/// believed as before. (The sensors stand last: their own rows hold exactly their marginal information.)
template <class S>
void replace_sensor_priors(Window<S>* w, const VioOptions<S>& options) {
  PackedTriangle<S> R = w->R();
  for (int j = camera_column(0); j < w->columns(); ++j) {
    for (int c = j; c <= w->columns(); ++c) R.row(j)[c] = S(0);
    const int i = j - camera_column(0), camera = i / kMaxCameraColumns;
    const S sigma = options.calibrated_share *
                    (j >= w->imu_column() ? imu_sigma(options, j - w->imu_column())
                                          : camera_sigma(options, w->theta.camera[camera], i % kMaxCameraColumns));
    if (sigma > S(0)) R.row(j)[j] = S(1) / sigma;
  }
}

/// Takes a calibration from outside while the filter runs. What it has estimated beside (motion, and biases above all, which took up
/// what the old calibration left) goes where the window's information puts it for the new one: the mean of R's other rows given a step
/// of the sensors. Without that the links of the next seconds would be broken by tens of sigmas.
template <class S>
void take_calibration(const Calibration<S>& theta, const VioOptions<S>& options, Window<S>* w) {
  S delta[kMaxTheta];   // effects behind the sensors included: the filter takes them as they are
  difference(w->theta, theta, delta);
  PackedTriangle<S> R = w->R();
  const S* from = delta;
  const auto put = [&](int first, int n) {
    for (int j = first; j < first + n; ++j) {
      S* r = R.row(j);
      for (int c = j; c < w->columns(); ++c) r[c] = c == j ? S(1) : S(0);
      r[w->columns()] = *from++;
    }
  };
  for (int j = camera_column(0); j < w->imu_column(); ++j) {
    for (int c = j; c <= w->columns(); ++c) R.row(j)[c] = S(0);   // a lens with fewer columns leaves some
  }
  for (int c = 0; c < theta.n_cameras; ++c) put(camera_column(c), theta.camera[c].columns());
  put(w->imu_column(), kImuColumns);
  apply_update(w);
  w->replace_calibration(theta);
  replace_sensor_priors(w, options);
}

}  // namespace SEGCAL_NS
