// SegmentEliminator: priors, links and damping of velocities and biases, one keyframe after the other.
#pragma once

#include "segments/elimination.h"

namespace SEGCAL_NS {

/// Everything that touches velocities and biases, in time order; to eliminate them, or to solve for them.
template <class S>
bool SegmentEliminator<S>::run_chain_step(const Segment<S>& segment, const GuestLink<S>& guest,
                                          const Calibration<S>& theta, const MeasurementModel<S>& model, S damping) {
  SEGCAL_SLICES(inner_place_) {
    if (guest.join == Join::imu) {
      SEGCAL_AWAIT(inner_place_, linked().link.step(segment, 0, theta, guest.state.b_a, guest.state.b_g, model.imu,
                                                    &imu_terms_, guest.kept));
      SEGCAL_PAUSE(inner_place_);
    }
    if (guest.join != Join::none) {
      link_guest(segment, guest, model);
      SEGCAL_PAUSE(inner_place_);
      SEGCAL_AWAIT(inner_place_, linked().chain.hand_over_step(&reduced_));
      SEGCAL_PAUSE(inner_place_);
    }
    for (j_ = 0; j_ < 3; ++j_) {
      start_chain(segment, guest, model, j_);
      SEGCAL_PAUSE(inner_place_);
    }
    for (k_ = 0; k_ < segment.n_keyframes; ++k_) {
      for (j_ = kPoseColumns; damping > S(0) && j_ < kStateColumns; ++j_) {
        linked().chain.add_scalar(j_ - kPoseColumns, damping / typical_step<S>(j_), S(0), &reduced_);
        SEGCAL_PAUSE(inner_place_);
      }
      if (k_ + 1 == segment.n_keyframes) break;
      SEGCAL_AWAIT(inner_place_, linked().link.step(segment, k_ + 1, theta, segment.states.x[k_].b_a,
                                                    segment.states.x[k_].b_g, model.imu, &imu_terms_, guest.kept));
      SEGCAL_PAUSE(inner_place_);
      link_keyframes(segment, k_, model);
      SEGCAL_PAUSE(inner_place_);
      linked().chain.finish_current();
      SEGCAL_PAUSE(inner_place_);
      linked().chain.move_on();
      SEGCAL_PAUSE(inner_place_);
      SEGCAL_AWAIT(inner_place_, linked().chain.hand_over_step(&reduced_));
      SEGCAL_PAUSE(inner_place_);
    }
  }
  SEGCAL_SLICES_END(inner_place_);
}

template <class S>
void SegmentEliminator<S>::link_keyframes(const Segment<S>& segment, int k, const MeasurementModel<S>& model) {
  const State<S>* x = segment.states.x;
  const ImuIntegral<S>& I = linked().link.result();
  ImuRows<S>& rows = linked().chain.begin_rows();
  link_rows(I, x[k], x[k + 1], x[k], x[k + 1], model.g, &rows);
  take_noise_off_scales(I, &rows);
  link_term_columns(rows, &imu_terms_);
  whiten(I, model.imu, &rows, &imu_terms_);
  linked().chain.begin_link(rows, imu_terms_, &reduced_);
}

/// The link, integrated already, or the walk from the guest to the first keyframe.
template <class S>
void SegmentEliminator<S>::link_guest(const Segment<S>& segment, const GuestLink<S>& guest,
                                      const MeasurementModel<S>& model) {
  const State<S>& x = segment.states.x[0];
  if (guest.join == Join::imu) {
    const ImuIntegral<S>& I = linked().link.result();
    ImuRows<S>& rows = linked().chain.begin_rows();
    link_rows(I, guest.state, x, guest.state, x, model.g, &rows);
    take_noise_off_scales(I, &rows);
    link_term_columns(rows, &imu_terms_);
    if (whiten(I, model.imu, &rows, &imu_terms_)) linked().chain.add_guest_link(rows, imu_terms_, &reduced_);
  } else {
    const S root = square_root(guest.gap_s);
    linked().chain.add_bias_link(x.b_a - guest.state.b_a, x.b_g - guest.state.b_g, S(1) / (model.imu.accel_walk * root),
                                 S(1) / (model.imu.gyro_walk * root), &reduced_);
  }
}

/// Priors on one axis of the first keyframe's velocity and, without a guest, biases.
template <class S>
void SegmentEliminator<S>::start_chain(const Segment<S>& segment, const GuestLink<S>& guest,
                                       const MeasurementModel<S>& model, int axis) {
  const State<S>& x = segment.states.x[0];
  linked().chain.add_scalar(axis, S(1) / model.velocity_sigma, -x.v_GI(axis) / model.velocity_sigma, &reduced_);
  if (guest.join != Join::none) return;
  linked().chain.add_scalar(3 + axis, S(1) / model.bias_a_sigma, -x.b_a(axis) / model.bias_a_sigma, &reduced_);
  linked().chain.add_scalar(6 + axis, S(1) / model.bias_g_sigma, -x.b_g(axis) / model.bias_g_sigma, &reduced_);
}

}  // namespace SEGCAL_NS
