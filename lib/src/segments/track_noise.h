// The errors of a corner along its track: white noise, and a random
// walk where the tracker drifts (docs/design.md, section 5).
//
// e_i = w_i + d_i per image axis, w_i white with pixel_sigma, d_i - d_(i-1) with variance q^2 dt. The walk counts from
// the track's first point in the segment: what it had gathered before is a shift of the corner on its surface, and so
// another landmark. The covariance C = pixel_sigma^2 I + q^2 min(t_i - t_0, t_j - t_0) has a Cholesky factor whose
// inverse needs no matrix: it is the Kalman filter of d, L^-1 r = (r_i - d_i|i-1) / sqrt(S_i) (innovations; Kailath,
// Sayed and Hassibi, Linear Estimation, Sec. 9.2). A few products per number, nothing subtracted that is nearly equal.
//
// Robust weights come first: the cost of a landmark's points is min over d of sum rho(|r_i - d_i|^2 / pixel_sigma^2) +
// sum rho(|d_i - d_(i-1)|^2 / (q^2 dt)), rho being Huber's: a point far off neither counts nor bends the walk, and a
// track that slips goes on from where it is. At its minimum it is the quadratic form of C with each variance divided by
// its weight, and has the same gradient.
#pragma once

#include "segments/segment.h"
#include "segments/weights.h"

namespace SEGCAL_NS {

/// Whether this build knows walks at all.
constexpr bool kTrackWalk = SEGCAL_TRACK_WALK != 0;

/// The points of one landmark, in time order; each camera's are a track of their own.
template <class S>
class TrackNoise {
 public:
  /// Are a landmark's points to be whitened together?
  static bool walks(const MeasurementModel<S>& model) { return kTrackWalk && model.track_walk > S(0); }

  void begin() { n_ = 0; }
  int points() const { return n_; }
  /// The next point: its time in us, and its residual in px. The builder
  /// takes one point per keyframe and camera, so that there is room.
  void add(int camera, std::int32_t t_us, const Vec2<S>& r, const MeasurementModel<S>& model);
  /// Robust weights, and what the points cost.
  S weigh(const MeasurementModel<S>& model);
  /// All weights one: for quadratic forms of what are no residuals.
  void weigh_equally(const MeasurementModel<S>& model);
  /// Whitens columns [first, last) of the points' rows, in px, two for each point one after the other.
  void whiten(S* rows, int stride, int first, int last) const;
  /// Squared whitened length of the residuals.
  S squared_length() const;
  /// Whitened residual of each point: the error that its track did not show before.
  void whitened(Vec2<S>* out) const;
  /// Residual of a point in px without the walk; after weigh().
  Vec2<S> without_walk(int i) const { return r_[i] - d_[i]; }

 private:
  void smooth();
  void set_gains();

  static constexpr int kPoints = kMaxKeyframes * kMaxCameras;
  std::int32_t n_ = 0;
  std::int8_t camera_[kPoints], before_[kPoints];  ///< `before_`: the point of the same camera before; -1: none
  std::int32_t t_us_[kPoints];
  S walked_[kPoints];  ///< px^2; variance of the walk since the point before
  S step_[kPoints];    ///< the same by weight
  S white_[kPoints];   ///< px^2; variance of the white noise, by weight
  S known_[kPoints];   ///< px^2; variance of the walk given the points up to this one
  S gain_[kPoints], scale_[kPoints];
  Vec2<S> r_[kPoints], d_[kPoints];
};

template <class S>
void TrackNoise<S>::add(int camera, std::int32_t t_us, const Vec2<S>& r, const MeasurementModel<S>& model) {
  eigen_assert(n_ < kPoints);
  int before = n_ - 1;
  while (before >= 0 && camera_[before] != camera) --before;
  camera_[n_] = static_cast<std::int8_t>(camera);
  before_[n_] = static_cast<std::int8_t>(before);
  t_us_[n_] = t_us;
  walked_[n_] = step_[n_] =
      before < 0 ? S(0) : model.track_walk * model.track_walk * (S(t_us - t_us_[before]) * S(1e-6));
  r_[n_++] = r;
}

/// The walk's best values at the present white variances: a Kalman filter and Rauch, Tung and Striebel's way back.
template <class S>
void TrackNoise<S>::smooth() {
  for (int i = 0; i < n_; ++i) {
    const int b = before_[i];
    const S before = b < 0 ? S(0) : known_[b] + step_[i];
    const S gain = before / (before + white_[i]);
    const Vec2<S> at = b < 0 ? Vec2<S>(Vec2<S>::Zero()) : d_[b];
    d_[i] = at + gain * (r_[i] - at);
    known_[i] = gain * white_[i];
  }
  for (int i = n_ - 1; i >= 0; --i) {
    const int b = before_[i];
    if (b >= 0) d_[b] += known_[b] / (known_[b] + step_[i]) * (d_[i] - d_[b]);
  }
}

template <class S>
void TrackNoise<S>::set_gains() {
  for (int i = 0; i < n_; ++i) {
    const S before = before_[i] < 0 ? S(0) : known_[before_[i]] + step_[i];
    gain_[i] = before / (before + white_[i]);
    known_[i] = gain_[i] * white_[i];
    scale_[i] = S(1) / square_root(before + white_[i]);
  }
}

template <class S>
S TrackNoise<S>::weigh(const MeasurementModel<S>& model) {
  constexpr int kMost = 100;
  constexpr S kSettled = std::is_same_v<S, float> ? S(1e-6) : S(1e-14);  // share of the cost
  const S variance = model.pixel_sigma * model.pixel_sigma;
  S cost = S(0);
  weigh_equally(model);
  for (int round = 0; round < kMost; ++round) {
    smooth();
    bool alike = true;
    S now = S(0);
    for (int i = 0; i < n_; ++i) {
      const RobustTerm<S> point = robust_term(model, without_walk(i).squaredNorm() / variance);
      now += point.cost;
      alike = alike && point.weight == S(1) && white_[i] == variance;
      white_[i] = variance / point.weight;
      if (before_[i] < 0) continue;
      const RobustTerm<S> step = robust_term(model, (d_[i] - d_[before_[i]]).squaredNorm() / walked_[i]);
      now += step.cost;
      alike = alike && step.weight == S(1) && step_[i] == walked_[i];
      step_[i] = walked_[i] / step.weight;
    }
    // Each round lowers the cost; rounding ends it.
    const bool settled = round > 0 && cost - now <= kSettled * now;
    cost = now;
    if (alike || settled) break;
  }
  set_gains();
  return cost;
}

template <class S>
void TrackNoise<S>::weigh_equally(const MeasurementModel<S>& model) {
  for (int i = 0; i < n_; ++i) {
    white_[i] = model.pixel_sigma * model.pixel_sigma;
    step_[i] = walked_[i];
  }
  set_gains();
}

template <class S>
void TrackNoise<S>::whiten(S* rows, int stride, int first, int last) const {
  constexpr int kStrip = 8;
  for (int strip = first; strip < last; strip += kStrip) {
    const int columns = last - strip < kStrip ? last - strip : kStrip;
    S d[kMaxCameras][2][kStrip] = {};
    for (int i = 0; i < n_; ++i) {
      for (int axis = 0; axis < 2; ++axis) {
        S* const row = rows + (2 * i + axis) * stride + strip;
        S* const at = d[camera_[i]][axis];
        for (int c = 0; c < columns; ++c) {
          const S innovation = row[c] - at[c];
          row[c] = scale_[i] * innovation;
          at[c] += gain_[i] * innovation;
        }
      }
    }
  }
}

template <class S>
void TrackNoise<S>::whitened(Vec2<S>* out) const {
  Vec2<S> d[kMaxCameras];
  for (Vec2<S>& at : d) at.setZero();
  for (int i = 0; i < n_; ++i) {
    Vec2<S>& at = d[camera_[i]];
    const Vec2<S> innovation = r_[i] - at;
    out[i] = scale_[i] * innovation;
    at += gain_[i] * innovation;
  }
}

template <class S>
S TrackNoise<S>::squared_length() const {
  Vec2<S> w[kPoints];
  whitened(w);
  S sum = S(0);
  for (int i = 0; i < n_; ++i) sum += w[i].squaredNorm();
  return sum;
}

}  // namespace SEGCAL_NS
