// A kept segment of the core, with calibration and weights, as the same templates have them in double.
#pragma once

#include <memory>

#include "segments/elimination.h"

namespace host {
namespace SEGCAL_NS {

template <class S>
::SEGCAL_NS::Calibration<double> in_double(const ::SEGCAL_NS::Calibration<S>& in) {
  ::SEGCAL_NS::Calibration<double> out;
  out.n_cameras = in.n_cameras;
  for (int c = 0; c < in.n_cameras; ++c) {
    const auto& from = in.camera[c];
    out.camera[c] = {from.model,
                     from.R_CI.template cast<double>(),
                     from.p_CI.template cast<double>(),
                     from.intrinsics.template cast<double>(),
                     from.distortion.template cast<double>(),
                     static_cast<double>(from.middle_line)};
  }
  const auto& imu = in.imu;
  out.imu = {imu.gyro_scale.template cast<double>(), imu.gyro_misalignment.template cast<double>(),
             imu.accel_scale.template cast<double>(), imu.accel_misalignment.template cast<double>(),
             imu.R_AI.template cast<double>()};
  for (int i = 0; i < in.effects.count(); ++i)
    out.effects.add(in.effects.term[i], static_cast<double>(in.effects.value[i]));
  out.effects.time_zero_ns = in.effects.time_zero_ns;
  return out;
}

template <class S>
::SEGCAL_NS::MeasurementModel<double> in_double(const ::SEGCAL_NS::MeasurementModel<S>& in) {
  ::SEGCAL_NS::MeasurementModel<double> out;
  out.imu = {in.imu.gyro, in.imu.gyro_walk, in.imu.accel, in.imu.accel_walk};
  out.pixel_sigma = in.pixel_sigma;
  out.track_walk = in.track_walk;
  out.g = in.g.template cast<double>();
  out.bias_a_sigma = in.bias_a_sigma;
  out.bias_g_sigma = in.bias_g_sigma;
  out.velocity_sigma = in.velocity_sigma;
  out.inverse_depth_sigma = in.inverse_depth_sigma;
  out.turned_inverse_depth_sigma = in.turned_inverse_depth_sigma;
  out.huber = in.huber;
  return out;
}

/// Measurements and states; ranges (rad/s, m/s^2): by which its samples are stored.
template <class S>
std::unique_ptr<::SEGCAL_NS::Segment<double>> in_double(const ::SEGCAL_NS::Segment<S>& in, double gyro_range,
                                                        double accel_range) {
  auto out = std::make_unique<::SEGCAL_NS::Segment<double>>();
  out->t0_ns = in.t0_ns;
  out->n_keyframes = in.n_keyframes;
  out->n_landmarks = in.n_landmarks;
  out->n_observations = in.n_observations;
  out->lead_us = in.lead_us;
  out->turned_only = in.turned_only;
  out->wide_depth_prior = in.wide_depth_prior;
  out->stamp_shift_ns = in.stamp_shift_ns;
  std::copy_n(in.t_us, in.n_keyframes, out->t_us);
  std::copy_n(in.warmth, in.n_keyframes, out->warmth);
  std::copy_n(in.first_observation, in.n_landmarks + 1, out->first_observation);
  std::copy_n(in.observation, in.n_observations, out->observation);
  out->imu.clear(gyro_range, accel_range);
  for (int i = 0; i < in.imu.size(); ++i) {
    const auto r = in.imu.reading(i);
    out->imu.push(in.imu.time(i), {r.gyro.template cast<double>(), r.accel.template cast<double>()});
  }
  for (int k = 0; k < in.n_keyframes; ++k) {
    const auto& x = in.states.x[k];
    out->states.x[k] = {x.R_GI.template cast<double>(), x.p_GI.template cast<double>(), x.v_GI.template cast<double>(),
                        x.b_a.template cast<double>(), x.b_g.template cast<double>()};
  }
  for (int j = 0; j < in.n_landmarks; ++j) {
    const auto& l = in.states.landmark[j];
    out->states.landmark[j] = {l.o.template cast<double>(), l.m.template cast<double>(), static_cast<double>(l.rho)};
  }
  return out;
}

}  // namespace SEGCAL_NS
}  // namespace host
