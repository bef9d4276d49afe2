// The triangle that a segment is reduced to:
// [poses 6 (K - 1) | last keyframe 15 | guest 15, where joined | IMU
// part of theta, IMU terms | ties 3 each | cameras, camera terms | rhs].
//
// Terms (sensors/effect_terms.h) are those of theta and, behind them, candidates that are only tested. What all
// segments have in common is [ties | cameras | IMU 15 | terms | rhs]: candidates stand last, so that the triangle's
// leading part is theta's alone.
//
// Cameras stand last in theta, beside the right-hand side, so that the landmarks' rows leave one gap in the middle. A
// tie is a landmark that other segments use too (calibration/ties.h): it stays, beside theta.
//
// Velocities and biases of all keyframes but the last are eliminated before (velocity_bias_chain.h): each of them
// touches its two neighbours only, so they never stand in this triangle, which is what keeps it small.
#pragma once

#include "math/near.h"
#include "math/one_of.h"
#include "math/qr.h"
#include "math/small_solvers.h"
#include "segments/segment.h"

namespace SEGCAL_NS {

constexpr int kVelocityBiasColumns = kStateColumns - kPoseColumns;
constexpr int kMaxTies = SEGCAL_MAX_TIES;
constexpr int kTieColumns = kLandmarkColumns * kMaxTies;
constexpr int kReducedColumns =
    kPoseColumns * (kMaxKeyframes - 1) + 2 * kStateColumns + kMaxWideTheta + kTieColumns + 1;

/// The ties that a segment sees, among all that there are.
struct TiedLandmarks {
  std::int32_t n = 0, total = 0;
  std::int16_t landmark[kMaxTies + 1] = {};  ///< index in the segment; (a place more: there may be no ties at all)
  std::int16_t number[kMaxTies + 1] = {};    ///< 0..total - 1

  /// Place of landmark j in this list; -1 if it is the segment's own.
  int place_of(int j) const {
    int t = n - 1;
    while (t >= 0 && landmark[t] != j) --t;
    return t;
  }
};

/// Where things stand. The last keyframe's pose follows the other poses, so pose k is always at 6 k.
struct ReducedLayout {
  int keyframes = 0, guest_columns = 0;
  int sensor_cameras = 0;  ///< theta's columns of all cameras
  int terms = 0;           ///< of theta and candidates
  int imu_terms = 0, camera_terms = 0;
  std::uint8_t imu_term[kMaxEffectColumns + 1] = {},
                                            camera_term[kMaxEffectColumns + 1] = {};  ///< number among all terms
  TiedLandmarks tied;

  void add_term(const Term& t) {
    if (t.of_imu()) {
      imu_term[imu_terms++] = static_cast<std::uint8_t>(terms++);
    } else {
      camera_term[camera_terms++] = static_cast<std::uint8_t>(terms++);
    }
  }

  int pose(int k) const { return kPoseColumns * k; }
  int last() const { return pose(keyframes - 1); }
  int guest() const { return last() + kStateColumns; }
  int theta() const { return guest() + guest_columns; }
  int imu() const { return theta(); }
  int imu_columns() const { return kImuColumns + imu_terms; }
  int tie(int t) const { return theta() + imu_columns() + kLandmarkColumns * t; }
  int cameras() const { return tie(tied.n); }
  /// Theta with candidates.
  int wide_theta() const { return sensor_cameras + kImuColumns + terms; }
  /// Columns that stay: theta, candidates and ties.
  int global_columns() const { return wide_theta() + kLandmarkColumns * tied.n; }
  /// Column of entry c of the wide theta.
  int column_of(int c) const {
    if (c < sensor_cameras) return cameras() + c;
    if (c < sensor_cameras + kImuColumns) return imu() + c - sensor_cameras;
    const int term = c - sensor_cameras - kImuColumns;
    for (int i = 0; i < imu_terms; ++i) {
      if (imu_term[i] == term) return imu() + kImuColumns + i;
    }
    int i = 0;
    while (camera_term[i] != term) ++i;
    return cameras() + sensor_cameras + i;
  }
  int rhs() const { return theta() + global_columns(); }
  int width() const { return rhs() + 1; }
};

template <class S>
class ReducedSystem {
 public:
  void begin(const ReducedLayout& layout) {
    layout_ = layout;
    seen_poses_ = 0;
    memory_.template begin<Triangle>();
    R().clear();
  }
  const ReducedLayout& layout() const { return layout_; }
  PackedTriangle<S> R() { return PackedTriangle<S>(numbers(), layout_.width()); }

  /// Begins to fold landmark rows: they touch the poses of keyframes first to last, cameras and, if `tied`, ties; the
  /// rows folded before touch no later poses than the latest so far. Cheap, if the landmarks that end early come first.
  void begin_visual(S* rows, int m, int stride, int first_keyframe, int last_keyframe, bool tied) {
    if (layout_.pose(last_keyframe + 1) > seen_poses_) seen_poses_ = layout_.pose(last_keyframe + 1);
    const ColumnGap gap{seen_poses_, tied ? layout_.tie(0) : layout_.cameras()};
    pending_ = {rows, m, stride, layout_.pose(first_keyframe), gap};
  }
  /// The same for rows that stand in this layout; columns before `first` are zero.
  void begin_fold(S* rows, int m, int stride, int first) { pending_ = {rows, m, stride, first, ColumnGap{}}; }
  /// Goes on with the fold that was begun, for some kFoldSlice products; true when it is done. Destroys the rows, which
  /// must stay where they are until then.
  bool fold_step() {
    PackedTriangle<S> triangle = R();
    const int width = layout_.width();
    const ColumnGap& gap = pending_.gap;
    if (pending_.next >= gap.first && pending_.next < gap.last) pending_.next = gap.last;
    int until = pending_.next, work = 0;
    while (until < width && work < kFoldSlice) work += pending_.m * (width - until++);
    fold_rows(triangle, pending_.rows.get(), pending_.m, pending_.stride, pending_.next, until, gap);
    pending_.next = until;
    return until == width;
  }

  /// The global part of row theta() + i, in the order that all
  /// segments share: [all ties | cameras | IMU | terms | rhs].
  void global_row(int i, S* out) { to_global_order(R().row(layout_.theta() + i), i, out); }

  /// The same for any row: entries before the i-th from theta() on are taken as zero.
  void to_global_order(const S* row, int i, S* out) const {
    const ReducedLayout& at = layout_;
    const int theta = kLandmarkColumns * at.tied.total;
    for (int c = 0; c < theta; ++c) out[c] = S(0);
    for (int c = 0; c < kLandmarkColumns * at.tied.n; ++c) {
      const int to = kLandmarkColumns * at.tied.number[c / kLandmarkColumns] + c % kLandmarkColumns;
      out[to] = at.imu_columns() + c < i ? S(0) : row[at.tie(0) + c];
    }
    for (int c = 0; c < at.wide_theta(); ++c) {
      const int from = at.column_of(c);
      out[theta + c] = from - at.theta() < i ? S(0) : row[from];
    }
    out[theta + at.wide_theta()] = row[at.rhs()];
  }

  /// Folds rows that stand in this layout; columns before `first` are zero. Destroys them.
  void fold(S* rows, int m, int stride, int first) {
    PackedTriangle<S> triangle = R();
    fold_rows(triangle, rows, m, stride, first, layout_.width());
  }
  /// One row with a single entry and its right-hand side.
  void fold_scalar(int column, S weight, S rhs) {
    clear_row();
    row_[column] = weight;
    row_[layout_.rhs()] = rhs;
    fold(row_, 1, kReducedColumns, column);
  }
  /// One row over the three rotation columns of pose k.
  void fold_rotation(int k, const Vec3<S>& direction, S weight) {
    clear_row();
    for (int i = 0; i < 3; ++i) row_[layout_.pose(k) + i] = weight * direction(i);
    fold(row_, 1, kReducedColumns, layout_.pose(k));
  }

  /// An X in the triangle's memory; what was eliminated is lost then.
  template <class X>
  X& begin_in_room() {
    static_assert(sizeof(X) <= sizeof(Room) && alignof(X) <= alignof(Room), "the triangle is too small for this");
    Room& room = memory_.template begin<Room>();
    room.set(sizeof(X));
    return *new (room.bytes) X;
  }
  template <class X>
  X& in_room() {
    eigen_assert(memory_.template get<Room>().is(sizeof(X)));
    return *std::launder(static_cast<X*>(static_cast<void*>(memory_.template get<Room>().bytes)));
  }
  static constexpr int kNumbers = packed_size(kReducedColumns);
  /// Of the triangle's first numbers: the rows above theta's, which are all that a step needs on its way back.
  int numbers_above_theta() const {
    return packed_size(layout_.width()) - packed_size(layout_.width() - layout_.theta());
  }
  /// The triangle's numbers, for who needs no triangle any more.
  S* numbers() { return memory_.template get<Triangle>().number; }

  /// x[j] for j < known, from x[known..rhs).
  void back_substitute(S* x, int known) {
    const PackedTriangle<S> triangle = R();
    const int n = layout_.rhs();
    for (int j = known - 1; j >= 0; --j) {
      const S* r = triangle.row(j);
      x[j] = over_pivot(less_products(r[n], r, x, j + 1, n), r[j]);
    }
  }

 private:
  void clear_row() {
    for (int c = 0; c < layout_.width(); ++c) row_[c] = S(0);
  }
  ReducedLayout layout_;
  struct PendingFold {
    Near<S> rows;
    std::int32_t m, stride, next;  ///< next: the column to go on with
    ColumnGap gap;
  };
  static constexpr int kFoldSlice = 40000;  // four operations each
  PendingFold pending_;
  int seen_poses_ = 0;  // columns of poses that landmark rows have touched, all those before the latest included
  struct Triangle {
    alignas(8) S number[kNumbers];
  };
  /// Knows by its size which of several types was begun there.
  struct Room : Held<kKnowsWhatItHolds> {
    alignas(8) unsigned char bytes[sizeof(Triangle)];
  };
  OneOf<Triangle, Room> memory_;
  S row_[kReducedColumns];
};

}  // namespace SEGCAL_NS
