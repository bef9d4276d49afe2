// A segment: K consecutive keyframes, the landmarks they see, and the raw IMU samples between them (paper, Sec. V-B).
// It holds its raw measurements, since calibration linearises it again at each new estimate.
#pragma once

#include <cstdint>
#include <type_traits>

#include "information/segment_information.h"
#include "segments/imu_store.h"
#include "segments/kept_links.h"
#include "segments/landmark.h"
#include "segments/pixel.h"
#include "sensors/roughness.h"

namespace SEGCAL_NS {

constexpr int kMaxKeyframes = SEGCAL_MAX_KEYFRAMES;
constexpr int kMaxLandmarks = SEGCAL_MAX_LANDMARKS;
constexpr int kMaxObservations = SEGCAL_MAX_OBSERVATIONS;

/// Bits that tell numbers up to n.
constexpr int bits_for(int n) {
  int bits = 1;
  while (n >> bits != 0) ++bits;
  return bits;
}
constexpr int kLandmarkBits = bits_for(kMaxLandmarks), kKeyframeBits = bits_for(kMaxKeyframes - 1),
              kCameraBits = bits_for(kMaxCameras - 1);
constexpr int kDroppedLandmark = (1 << kLandmarkBits) - 1;  ///< landmark of an image point that is to vanish
using ObservationBits =
    std::conditional_t<kLandmarkBits + kKeyframeBits + kCameraBits + 1 <= 16, std::uint16_t, std::uint32_t>;

/// One image point of a landmark.
struct Observation {
  StoredPixel u, v;                          ///< px
  ObservationBits landmark : kLandmarkBits;  ///< index in the segment
  ObservationBits keyframe : kKeyframeBits;  ///< index in the segment
  ObservationBits camera : kCameraBits;
  ObservationBits rejected : 1;  ///< far off although the model fits: left out by the last calibration
};

/// What the optimiser moves in a segment.
template <class S>
struct SegmentStates {
  State<S> x[kMaxKeyframes];
  Landmark<S> landmark[kMaxLandmarks];
};

/// Scalar metrics of a segment's information (paper, Sec. V-B); lower is better.
template <class S>
struct Metrics {
  S A = S(0), D = S(0), E = S(0);  ///< trace, log determinant, largest eigenvalue of the normalised covariance
  S gain = S(0);                   ///< nats that the segment adds to the prior: D(prior)/2 - D/2
  std::int32_t rank = 0;           ///< directions whose sigma falls below half the prior's
};

/// A segment's particulars without its measurements.
template <class S>
struct SegmentSummary {
  bool valid = false, kept = false, outdated = false, settled = false;
  std::int64_t start_ns = 0, end_ns = 0;
  std::uint32_t session = 0, serial = 0;
  std::int32_t keyframes = 0, landmarks = 0, points = 0;
  Metrics<S> metrics;
};

template <class S>
class LinkIntegration;

template <class S>
struct Segment {
  std::int64_t t0_ns = 0;    ///< stamp of the first keyframe, IMU clock
  std::uint32_t serial = 0;  ///< grows by one with each segment cut from the stream
  std::uint32_t session = 0;
  std::uint32_t frame = 0;  ///< segments with the same number have their states in the same G
  std::int32_t n_keyframes = 0, n_landmarks = 0, n_observations = 0;
  /// > 0: the samples begin this long (us) before the first keyframe, at the last keyframe of segment `serial` - 1.
  std::int32_t lead_us = 0;
  /// The images show no translation (visible_translation.h): inverse distances are linearised as if there were none.
  bool turned_only = false;
  /// The weak prior on inverse distances is the wide one (weights.h); fixed while a fit iterates.
  bool wide_depth_prior = false;
  /// m, in the odometry's frame: states and landmarks count from here. Float resolves what is near.
  double origin[3] = {0, 0, 0};
  /// Keyframe times are camera stamps moved by this much: the time offset that was known when the segment was built.
  std::int32_t stamp_shift_ns = 0;
  std::int32_t t_us[kMaxKeyframes];  ///< keyframe times after t0
  float warmth[kMaxKeyframes];       ///< degC above 25; 0 where the IMU does not tell
  std::uint32_t track_id[kMaxLandmarks];
  /// Observations of landmark j: [first[j], first[j + 1]), one at least.
  std::uint16_t first_observation[kMaxLandmarks + 1];
  Observation observation[kMaxObservations];  ///< sorted by landmark once the segment is closed
  ImuStore<S> imu;
  SegmentStates<S> states;
  SegmentInformation<S> information;
  Metrics<S> metrics;

  /// Keyframe of landmark j's last image point; -1 without any.
  int last_keyframe(int j) const {
    int last = -1;
    for (int o = first_observation[j]; o < first_observation[j + 1]; ++o) {
      if (observation[o].keyframe > last) last = observation[o].keyframe;
    }
    return last;
  }

  /// Integrates link k: keyframe k - 1 (or the previous segment's last one, k = 0) to keyframe k.
  /// `columns`: derivatives by terms that are wanted beside those by biases and theta's 15.
  ImuIntegral<S> integrate(int k, const Calibration<S>& theta, const Vec3<S>& b_a, const Vec3<S>& b_g,
                           const ImuNoise<S>& noise, ImuTermColumns<S>* columns = nullptr) const {
    LinkIntegration<S> link;
    while (!link.step(*this, k, theta, b_a, b_g, noise, columns)) {
    }
    return link.result();
  }
  /// The noise of link k's samples as they show it.
  ImuNoise<S> noise_of(int k, const ImuNoise<S>& stated) const {
    return noise_in(imu, stated, link_start(k), t_us[k], S(1e-6));
  }
  /// What terms need to know about link k.
  Stretch<S> stretch(int k, const Calibration<S>& theta) const {
    const S start = S(t0_ns - theta.effects.time_zero_ns) * S(1e-9);
    const int before = k > 0 ? k - 1 : 0;  // of the link from the previous segment only the far end is known here
    return {S(warmth[before]),      S(warmth[k]), start + S(link_start(k)) * S(1e-6), start + S(t_us[k]) * S(1e-6),
            &states.x[before].R_GI, k > 0};
  }
  bool has_origin_of(const Segment& other) const {
    return origin[0] == other.origin[0] && origin[1] == other.origin[1] && origin[2] == other.origin[2];
  }
  /// A position that counts from another segment's origin, counted from this one's.
  Vec3<S> from_origin_of(const Segment& other, const Vec3<S>& p) const {
    Vec3<S> out;
    for (int i = 0; i < 3; ++i) out(i) = static_cast<S>(other.origin[i] - origin[i] + static_cast<double>(p(i)));
    return out;
  }
  std::int32_t link_start(int k) const { return k == 0 ? -lead_us : t_us[k - 1]; }
};

/// Segment::integrate() in slices.
template <class S>
class LinkIntegration {
 public:
  /// `kept`: where the integral may be known from before, and stays known; null: nowhere.
  bool step(const Segment<S>& s, int k, const Calibration<S>& theta, const Vec3<S>& b_a, const Vec3<S>& b_g,
            const ImuNoise<S>& noise, ImuTermColumns<S>* columns = nullptr,
            KeptLinks<S, kMaxKeyframes>* kept = nullptr) {
    // With terms of the IMU it depends on more: those are integrated each time.
    const bool keeps = kKeepsEliminations && kept && !theta.effects.any_of_imu() && !(columns && columns->count() > 0);
    SEGCAL_SLICES(place_) {
      if (const ImuIntegral<S>* known = keeps ? kept->find(k, theta.imu, b_a, b_g) : nullptr) {
        integrator_.take(*known);
        break;
      }
      integrator_.begin(theta.imu, b_a, b_g, s.noise_of(k, noise), &theta.effects, columns);
      samples_.restart();
      SEGCAL_AWAIT(place_, samples_.step(s.imu, s.link_start(k), s.t_us[k], S(1e-6), &integrator_,
                                         integrator_.wants_surroundings() ? s.stretch(k, theta) : Stretch<S>{}));
      if (keeps) kept->keep(k, theta.imu, b_a, b_g, integrator_.result());
    }
    SEGCAL_SLICES_END(place_);
  }
  const ImuIntegral<S>& result() { return integrator_.result(); }
  void restart() { place_ = 0; }

 private:
  Place place_ = 0;
  ImuIntegrator<S> integrator_;
  SampleIntegration<S, std::int32_t> samples_;
};

template <class S>
SegmentSummary<S> summary_of(const Segment<S>& s) {
  SegmentSummary<S> out;
  out.valid = out.settled = true;  // what is kept is
  out.start_ns = s.t0_ns;
  out.end_ns = s.t0_ns + std::int64_t(s.t_us[s.n_keyframes - 1]) * 1000;
  out.session = s.session;
  out.serial = s.serial;
  out.keyframes = s.n_keyframes;
  out.landmarks = s.n_landmarks;
  out.points = s.n_observations;
  out.metrics = s.metrics;
  return out;
}

/// Over its keyframes, degC above 25.
template <class S>
S mean_warmth(const Segment<S>& segment) {
  S sum = S(0);
  for (int k = 0; k < segment.n_keyframes; ++k) sum += S(segment.warmth[k]);
  return segment.n_keyframes > 0 ? sum / S(segment.n_keyframes) : S(0);
}

}  // namespace SEGCAL_NS
