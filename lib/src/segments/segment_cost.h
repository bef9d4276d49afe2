// The cost of a segment at given states and theta: the sum that Levenberg-Marquardt must bring down (paper, Sec. IV-C).
#pragma once

#include "segments/elimination.h"

namespace SEGCAL_NS {

/// Squared whitened length of a link's residual.
template <class S>
S link_cost(const ImuIntegral<S>& I, const State<S>& x0, const State<S>& x1, const MeasurementModel<S>& model) {
  const Vec<S, 15> r = link_residual(I, x0, x1, model.g);
  Vec<S, 15> w;
  return whiten_residual(I, model.imu, r, &w) ? w.squaredNorm() : S(0);
}

/// Cost of the prior on a tie's inverse distance, from its fixed point: no segment's camera is the first.
template <class S>
S inverse_depth_cost(const Landmark<S>& l, S sigma) {
  const S prior = l.rho / sigma;
  return prior * prior;
}

/// Gathers the residuals of landmark j's image points, with the
/// rejected ones or without. Returns how many have no image.
template <class S>
int add_residuals(const Segment<S>& segment, int j, const Calibration<S>& theta, const MeasurementModel<S>& model,
                  bool rejected, TrackNoise<S>* track) {
  int unseen = 0;
  track->begin();
  for (int o = segment.first_observation[j]; o < segment.first_observation[j + 1]; ++o) {
    const Observation& z = segment.observation[o];
    if (z.rejected && !rejected) continue;
    Vec2<S> r;
    if (point_residual(segment, z, theta, model.g, segment.states.landmark[j], &r)) {
      track->add(z.camera, segment.t_us[z.keyframe], r, model);
    } else {
      ++unseen;
    }
  }
  return unseen;
}

/// Robust cost of landmark j's image points, and the prior on its inverse distance; that of a tie is not the segment's.
template <class S>
S image_cost(const Segment<S>& segment, int j, const TiedLandmarks& tied, const Calibration<S>& theta,
             const MeasurementModel<S>& model) {
  const S inverse_variance = S(1) / (model.pixel_sigma * model.pixel_sigma);
  const Landmark<S>& l = segment.states.landmark[j];
  S sum = tied.place_of(j) >= 0 ? S(0) : depth_prior_cost(segment, j, l, theta, model);
  if constexpr (kTrackWalk) {
    if (TrackNoise<S>::walks(model)) {
      TrackNoise<S> track;
      sum += model.huber * model.huber * S(add_residuals(segment, j, theta, model, false, &track));
      return sum + track.weigh(model);
    }
  }
  for (int o = segment.first_observation[j]; o < segment.first_observation[j + 1]; ++o) {
    const Observation& z = segment.observation[o];
    if (z.rejected) continue;
    Vec2<S> r;
    const bool seen = point_residual(segment, z, theta, model.g, l, &r);
    sum += seen ? robust_term(model, r.squaredNorm() * inverse_variance).cost : model.huber * model.huber;
  }
  return sum;
}

/// Would a small step take an image point out of sight?
template <class S>
bool at_edge(const Segment<S>& segment, const Observation& z, const Calibration<S>& theta, const Vec3<S>& g) {
  const Exposure<S> x = exposure_of(segment, z, theta, g, false);
  return with_camera(z, theta, x.warmth, [&](const CameraCalibration<S>& camera) {
    return !well_inside(camera, homogeneous_in_camera(camera, x.R_GI, x.p_GI, segment.states.landmark[z.landmark]));
  });
}

/// Marks points of landmark j that are farther than `longest` px from where its track should be, or at the lens' edge.
template <class S>
int mark_outliers_of(int j, const Calibration<S>& theta, const MeasurementModel<S>& model, S longest,
                     Segment<S>* segment) {
  TrackNoise<S> track;
  add_residuals(*segment, j, theta, model, true, &track);
  track.weigh(model);
  int marked = 0, point = 0;
  for (int o = segment->first_observation[j]; o < segment->first_observation[j + 1]; ++o) {
    Observation& z = segment->observation[o];
    Vec2<S> r;
    const bool seen = point_residual(*segment, z, theta, model.g, segment->states.landmark[j], &r);
    const bool far = seen && track.without_walk(point++).squaredNorm() > longest * longest;
    z.rejected = !seen || far || at_edge(*segment, z, theta, model.g) ? 1 : 0;
    marked += z.rejected;
  }
  return marked;
}

constexpr int kLandmarksPerSlice = 8;

/// Of landmarks `first` to `most` - 1, as far as there are: marks image points whose whitened residual is longer than
/// `limit`, and those at the lens' edge, and takes back earlier marks. Returns their number.
template <class S>
int mark_outliers(const Calibration<S>& theta, const MeasurementModel<S>& model, S limit, int first, int most,
                  Segment<S>* segment) {
  int marked = 0;
  const int end = most < segment->n_landmarks ? most : segment->n_landmarks;
  if constexpr (kTrackWalk) {
    if (TrackNoise<S>::walks(model)) {
      for (int j = first; j < end; ++j) {
        marked += mark_outliers_of(j, theta, model, limit * model.pixel_sigma, segment);
      }
      return marked;
    }
  }
  for (int o = segment->first_observation[first]; o < segment->first_observation[end]; ++o) {
    Observation& z = segment->observation[o];
    Vec2<S> r;
    const bool seen = point_residual(*segment, z, theta, model.g, segment->states.landmark[z.landmark], &r);
    const S longest = limit * model.pixel_sigma;
    z.rejected = !seen || r.squaredNorm() > longest * longest || at_edge(*segment, z, theta, model.g) ? 1 : 0;
    marked += z.rejected;
  }
  return marked;
}

template <class S>
int mark_outliers(const Calibration<S>& theta, const MeasurementModel<S>& model, S limit, Segment<S>* segment) {
  return mark_outliers(theta, model, limit, 0, segment->n_landmarks, segment);
}

/// Cost of what ties the first keyframe down. `link`: integrated from the guest, for Join::imu.
template <class S>
S start_cost(const Segment<S>& segment, const GuestLink<S>& guest, LinkIntegration<S>* link,
             const MeasurementModel<S>& model) {
  const State<S>* x = segment.states.x;
  S total = (x[0].v_GI / model.velocity_sigma).squaredNorm();
  if (guest.join == Join::imu) {
    total += link_cost(link->result(), guest.state, x[0], model);
  } else if (guest.join == Join::bias) {
    total += (x[0].b_a - guest.state.b_a).squaredNorm() / (model.imu.accel_walk * model.imu.accel_walk * guest.gap_s);
    total += (x[0].b_g - guest.state.b_g).squaredNorm() / (model.imu.gyro_walk * model.imu.gyro_walk * guest.gap_s);
  } else {
    total += (x[0].b_a / model.bias_a_sigma).squaredNorm() + (x[0].b_g / model.bias_g_sigma).squaredNorm();
  }
  return total;
}

/// Costs of a segment in slices: landmark by landmark, and IMU link by IMU link.
template <class S>
class CostSteps {
 public:
  /// Cost of the IMU links and of what starts a partition; true when inertial() is it.
  bool inertial_step(const Segment<S>& segment, const GuestLink<S>& guest, const Calibration<S>& theta,
                     const MeasurementModel<S>& model) {
    SEGCAL_SLICES(place_) {
      link_.restart();
      if (guest.join == Join::imu) {
        SEGCAL_AWAIT(place_,
                     link_.step(segment, 0, theta, guest.state.b_a, guest.state.b_g, model.imu, nullptr, guest.kept));
      }
      inertial_ = start_cost(segment, guest, &link_, model);
      SEGCAL_PAUSE(place_);
      for (k_ = 0; k_ + 1 < segment.n_keyframes; ++k_) {
        SEGCAL_AWAIT(place_, link_.step(segment, k_ + 1, theta, segment.states.x[k_].b_a, segment.states.x[k_].b_g,
                                        model.imu, nullptr, guest.kept));
        inertial_ += link_cost(link_.result(), segment.states.x[k_], segment.states.x[k_ + 1], model);
        SEGCAL_PAUSE(place_);
      }
    }
    SEGCAL_SLICES_END(place_);
  }
  S inertial() const { return inertial_; }

  /// All of a segment's cost; true when total() is it.
  bool step(const Segment<S>& segment, const GuestLink<S>& guest, const Calibration<S>& theta,
            const MeasurementModel<S>& model) {
    SEGCAL_SLICES(image_place_) {
      SEGCAL_AWAIT(image_place_, inertial_step(segment, guest, theta, model));
      total_ = S(0);
      for (k_ = 0; k_ < segment.n_landmarks; ++k_) {
        total_ += image_cost(segment, k_, guest.tied, theta, model);
        if (k_ % kLandmarksPerSlice == kLandmarksPerSlice - 1) SEGCAL_PAUSE(image_place_);
      }
      total_ += inertial_;
    }
    SEGCAL_SLICES_END(image_place_);
  }
  S total() const { return total_; }
  void restart() { place_ = image_place_ = 0; }

 private:
  Place place_ = 0, image_place_ = 0;
  std::int32_t k_ = 0;  // keyframe, then landmark
  S inertial_ = S(0), total_ = S(0);
  LinkIntegration<S> link_;
};

template <class S>
S segment_cost(const Segment<S>& segment, const GuestLink<S>& guest, const Calibration<S>& theta,
               const MeasurementModel<S>& model) {
  CostSteps<S> cost;
  while (!cost.step(segment, guest, theta, model)) {
  }
  return cost.total();
}

/// False if the states break the segment's own IMU links by a hundred sigmas (`cost`: their inertial cost, alone): the
/// odometry that gave them had not settled, and a linearisation at them would mean nothing. `effects`: the model may
/// lack one, which breaks links as well (4 ms between camera and gyroscope, shaken by hand, by five hundred): then it
/// is a thousand sigmas, from where a fit still finds home.
template <class S>
bool follows_its_imu(const Segment<S>& segment, S cost, bool effects) {
  return cost < (effects ? S(1e6) : S(1e4)) * S(kStateColumns * segment.n_keyframes);  // false for NaN too
}

}  // namespace SEGCAL_NS
