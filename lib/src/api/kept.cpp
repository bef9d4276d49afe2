// The C API's view of the kept segments as calibration had them: states, landmarks, image points, samples, links.
// Enough to repeat a calibration with another solver.
#include "api/handle.h"

using namespace SEGCAL_NS;

extern "C" {

[[gnu::cold]] int segcal_get_keyframes(const segcal_t* device, int32_t index, segcal_state_t* out, int32_t capacity) {
  const CDevice* d;
  const Segment<Real>* s;
  const int error = open_slot(device, index, out, capacity, &d, &s);
  if (error != SEGCAL_OK) return error;
  const int n = s->n_keyframes < capacity ? s->n_keyframes : capacity;
  for (int k = 0; k < n; ++k) state_to_c(s->states.x[k], s->origin, keyframe_time(*s, k), &out[k]);
  return n;
}

[[gnu::cold]] int segcal_get_landmarks(const segcal_t* device, int32_t index, segcal_landmark_t* out,
                                       int32_t capacity) {
  const CDevice* d;
  const Segment<Real>* s;
  const int error = open_slot(device, index, out, capacity, &d, &s);
  if (error != SEGCAL_OK) return error;
  const int place = d->device.calibrator().place_of(s);
  const Ties<Real>& ties = d->device.calibrator().ties();
  const int n = s->n_landmarks < capacity ? s->n_landmarks : capacity;
  for (int j = 0; j < n; ++j) {
    const Landmark<Real>& l = s->states.landmark[j];
    out[j].track_id = s->track_id[j];
    out[j].tie = -1;
    for (int t = 0; place >= 0 && t < ties.count(); ++t) {
      if (ties.landmark(t, place) == j) out[j].tie = t;
    }
    for (int i = 0; i < 3; ++i) {
      out[j].anchor[i] = s->origin[i] + static_cast<double>(l.o(i));
      out[j].direction[i] = static_cast<double>(l.m(i));
    }
    out[j].inverse_distance = static_cast<double>(l.rho);
  }
  return n;
}

[[gnu::cold]] int segcal_get_points(const segcal_t* device, int32_t index, segcal_measured_point_t* out,
                                    int32_t capacity) {
  const CDevice* d;
  const Segment<Real>* s;
  const int error = open_slot(device, index, out, capacity, &d, &s);
  if (error != SEGCAL_OK) return error;
  const int n = s->n_observations < capacity ? s->n_observations : capacity;
  for (int o = 0; o < n; ++o) {
    const Observation& z = s->observation[o];
    out[o] = {z.landmark, z.keyframe, z.camera, z.rejected, z.u, z.v};
  }
  return n;
}

[[gnu::cold]] int segcal_get_samples(const segcal_t* device, int32_t index, segcal_imu_t* out, int32_t capacity) {
  const CDevice* d;
  const Segment<Real>* s;
  const int error = open_slot(device, index, out, capacity, &d, &s);
  if (error != SEGCAL_OK) return error;
  const int n = s->imu.size() < capacity ? s->imu.size() : capacity;
  for (int i = 0; i < n; ++i) {
    const InertialReading<Real> reading = s->imu.reading(i);
    out[i].t_ns = s->t0_ns + std::int64_t(s->imu.time(i)) * 1000;
    for (int k = 0; k < 3; ++k) {
      out[i].gyro[k] = static_cast<float>(reading.gyro(k));
      out[i].accel[k] = static_cast<float>(reading.accel(k));
    }
  }
  return n;
}

[[gnu::cold]] int segcal_get_link(const segcal_t* device, int32_t index, segcal_link_t* out) {
  const CDevice* d;
  const Segment<Real>* s;
  const int error = open_slot(device, index, out, 0, &d, &s);
  if (error != SEGCAL_OK) return error;
  const int place = d->device.calibrator().place_of(s);
  if (place < 0) return SEGCAL_ERROR_STATE;
  const SegmentLink<Real>& link = d->device.calibrator().link(place);
  out->place = place;
  out->join = static_cast<int32_t>(link.join);
  out->gap_s = static_cast<double>(link.gap_s);
  out->lead_ns = std::int64_t(s->lead_us) * 1000;
  out->turned_only = s->wide_depth_prior ? 1 : 0;
  return SEGCAL_OK;
}

[[gnu::cold]] int segcal_get_model(const segcal_t* device, segcal_model_t* out) {
  if (!out) return SEGCAL_ERROR_NULL;
  const CDevice* d = open(device);
  if (!d) return SEGCAL_ERROR_STATE;
  const MeasurementModel<Real>& m = d->device.options().model;
  const auto number = [](Real value) { return static_cast<double>(value); };
  *out = {number(m.imu.gyro),
          number(m.imu.gyro_walk),
          number(m.imu.accel),
          number(m.imu.accel_walk),
          number(-m.g.z()),
          number(m.pixel_sigma),
          number(m.huber),
          number(m.bias_a_sigma),
          number(m.bias_g_sigma),
          number(m.velocity_sigma),
          number(m.inverse_depth_sigma),
          number(m.turned_inverse_depth_sigma),
          number(m.track_walk)};
  return SEGCAL_OK;
}

}  // extern "C"
