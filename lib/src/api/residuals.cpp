// The C API's answers: what a kept segment leaves over at the calibration, point by point and link by link.
#include "api/handle.h"

namespace SEGCAL_NS {
namespace {

/// Whitened residuals of a segment's points where tracks drift.
int walking_residuals(const Segment<Real>& s, const Calibration<Real>& theta, const MeasurementModel<Real>& model,
                      segcal_point_residual_t* out, int capacity) {
  int n = 0;
  for (int j = 0; j < s.n_landmarks && n < capacity; ++j) {
    TrackNoise<Real> track;
    Vec2<Real> whitened[kMaxKeyframes * kMaxCameras];
    add_residuals(s, j, theta, model, false, &track);
    track.weigh_equally(model);
    track.whitened(whitened);
    int point = 0;
    for (int o = s.first_observation[j]; o < s.first_observation[j + 1] && n < capacity; ++o) {
      const Observation& z = s.observation[o];
      Vec2<Real> r;
      if (z.rejected || !point_residual(s, z, theta, model.g, s.states.landmark[j], &r)) continue;
      out[n++] = {keyframe_time(s, z.keyframe), z.camera, static_cast<float>(whitened[point].x()),
                  static_cast<float>(whitened[point].y())};
      ++point;
    }
  }
  return n;
}

}  // namespace
}  // namespace SEGCAL_NS

using namespace SEGCAL_NS;

extern "C" {

[[gnu::cold]] int segcal_get_point_residuals(const segcal_t* device, int32_t index, segcal_point_residual_t* out,
                                             int32_t capacity) {
  const CDevice* d;
  const Segment<Real>* s;
  const int error = open_slot(device, index, out, capacity, &d, &s);
  if (error != SEGCAL_OK) return error;
  int n = 0;
  const MeasurementModel<Real>& model = d->device.options().model;
  if constexpr (kTrackWalk) {
    if (TrackNoise<Real>::walks(model)) return walking_residuals(*s, d->device.fitted_theta(), model, out, capacity);
  }
  const Real sigma = model.pixel_sigma;
  for (int o = 0; o < s->n_observations && n < capacity; ++o) {
    const Observation& z = s->observation[o];
    if (z.rejected) continue;
    Vec2<Real> r;
    if (!point_residual(*s, z, d->device.fitted_theta(), d->device.options().model.g, s->states.landmark[z.landmark],
                        &r)) {
      continue;
    }
    out[n++] = {keyframe_time(*s, z.keyframe), z.camera, static_cast<float>(r.x() / sigma),
                static_cast<float>(r.y() / sigma)};
  }
  return n;
}

[[gnu::cold]] int segcal_get_imu_residuals(const segcal_t* device, int32_t index, segcal_imu_residual_t* out,
                                           int32_t capacity) {
  const CDevice* d;
  const Segment<Real>* s;
  const int error = open_slot(device, index, out, capacity, &d, &s);
  if (error != SEGCAL_OK) return error;
  const MeasurementModel<Real>& model = d->device.options().model;
  int n = 0;
  for (int k = 1; k < s->n_keyframes && n < capacity; ++k) {
    const State<Real>* x = s->states.x;
    const ImuIntegral<Real> I = s->integrate(k, d->device.fitted_theta(), x[k - 1].b_a, x[k - 1].b_g, model.imu);
    Vec<Real, 15> w;
    if (!whiten_residual(I, model.imu, link_residual(I, x[k - 1], x[k], model.g), &w)) continue;
    out[n].t_ns = keyframe_time(*s, k);
    for (int i = 0; i < 3; ++i) {
      out[n].rotation[i] = static_cast<float>(w(i));
      out[n].velocity[i] = static_cast<float>(w(3 + i));
      out[n].position[i] = static_cast<float>(w(6 + i));
    }
    ++n;
  }
  return n;
}

}  // extern "C"
