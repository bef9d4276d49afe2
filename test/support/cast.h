// The same calibration, state, landmark or segment in another scalar type.
#pragma once

#include <memory>
#include <vector>

#include "segments/segment.h"

namespace test {

using namespace SEGCAL_NS;

template <class To, class From>
CameraCalibration<To> cast(const CameraCalibration<From>& a) {
  CameraCalibration<To> b;
  b.model = a.model;
  b.R_CI = a.R_CI.template cast<To>();
  b.p_CI = a.p_CI.template cast<To>();
  b.intrinsics = a.intrinsics.template cast<To>();
  b.distortion = a.distortion.template cast<To>();
  b.middle_line = To(a.middle_line);
  return b;
}

template <class To, class From>
ImuCalibration<To> cast(const ImuCalibration<From>& a) {
  ImuCalibration<To> b;
  b.gyro_scale = a.gyro_scale.template cast<To>();
  b.gyro_misalignment = a.gyro_misalignment.template cast<To>();
  b.accel_scale = a.accel_scale.template cast<To>();
  b.accel_misalignment = a.accel_misalignment.template cast<To>();
  b.R_AI = a.R_AI.template cast<To>();
  return b;
}

template <class To, class From>
Calibration<To> cast(const Calibration<From>& a) {
  Calibration<To> b;
  b.n_cameras = a.n_cameras;
  for (int c = 0; c < a.n_cameras; ++c) b.camera[c] = cast<To>(a.camera[c]);
  b.imu = cast<To>(a.imu);
  for (int i = 0; i < a.effects.count(); ++i) b.effects.add(a.effects.term[i], To(a.effects.value[i]));
  b.effects.time_zero_ns = a.effects.time_zero_ns;
  return b;
}

template <class To, class From>
State<To> cast(const State<From>& a) {
  State<To> b;
  b.R_GI = a.R_GI.template cast<To>();
  b.p_GI = a.p_GI.template cast<To>();
  b.v_GI = a.v_GI.template cast<To>();
  b.b_a = a.b_a.template cast<To>();
  b.b_g = a.b_g.template cast<To>();
  return b;
}

template <class To, class From>
Landmark<To> cast(const Landmark<From>& a) {
  return {a.o.template cast<To>(), a.m.template cast<To>(), To(a.rho)};
}

template <class To, class From>
InertialReading<To> cast(const InertialReading<From>& a) {
  return {a.gyro.template cast<To>(), a.accel.template cast<To>()};
}

/// Everything but the information, which belongs to one scalar type's elimination.
template <class To, class From>
void cast(const Segment<From>& a, Segment<To>* b) {
  b->t0_ns = a.t0_ns;
  b->serial = a.serial;
  b->session = a.session;
  b->frame = a.frame;
  b->n_keyframes = a.n_keyframes;
  b->n_landmarks = a.n_landmarks;
  b->n_observations = a.n_observations;
  b->lead_us = a.lead_us;
  b->stamp_shift_ns = a.stamp_shift_ns;
  for (int k = 0; k < a.n_keyframes; ++k) {
    b->t_us[k] = a.t_us[k];
    b->warmth[k] = a.warmth[k];
    b->states.x[k] = cast<To>(a.states.x[k]);
  }
  b->first_observation[0] = 0;
  for (int j = 0; j < a.n_landmarks; ++j) {
    b->track_id[j] = a.track_id[j];
    b->first_observation[j + 1] = a.first_observation[j + 1];
    b->states.landmark[j] = cast<To>(a.states.landmark[j]);
  }
  for (int o = 0; o < a.n_observations; ++o) b->observation[o] = a.observation[o];
  b->imu.clear();
  for (int i = 0; i < a.imu.size(); ++i) b->imu.push(a.imu.time(i), cast<To>(a.imu.reading(i)));
}

/// Segments in another scalar type, for a calibrator to move.
template <class To>
struct Copies {
  std::vector<std::unique_ptr<Segment<To>>> owned;
  Segment<To>* pointer[SEGCAL_MAX_SEGMENTS];

  template <class From>
  explicit Copies(const std::vector<std::unique_ptr<Segment<From>>>& segments) {
    for (const auto& segment : segments) {
      owned.push_back(std::make_unique<Segment<To>>());
      cast<To>(*segment, owned.back().get());
      pointer[owned.size() - 1] = owned.back().get();
    }
  }
  int count() const { return static_cast<int>(owned.size()); }
};

}  // namespace test
