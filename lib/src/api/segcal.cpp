// The C API: checks arguments, converts, and calls the device. Feeding and working; results are in results.cpp.
#include "segcal/segcal.h"

#include "api/convert.h"
#include "api/handle.h"

namespace SEGCAL_NS {

namespace {

int code(Taken taken) {
  switch (taken) {
    case Taken::ok: return SEGCAL_OK;
    case Taken::waiting: return SEGCAL_WAITING;
    case Taken::skipped: return SEGCAL_SKIPPED;
    case Taken::tracking: return SEGCAL_TRACKING;
    case Taken::lost: return SEGCAL_LOST;
    case Taken::not_finite: return SEGCAL_ERROR_NOT_FINITE;
    default: return SEGCAL_ERROR_STAMP;
  }
}

int check_points(const CDevice& d, const segcal_point_t* points, std::int32_t n) {
  if (!points && n > 0) return SEGCAL_ERROR_NULL;
  if (n < 0 || n > kMaxFramePoints) return SEGCAL_ERROR_SIZE;
  for (std::int32_t i = 0; i < n; ++i) {
    if (points[i].camera < 0 || points[i].camera >= d.device.theta().n_cameras) return SEGCAL_ERROR_CAMERA;
  }
  return SEGCAL_OK;
}

/// Reads one point at a time: they are copied once, into the frame that waits.
struct PointReader {
  const segcal_point_t* points;
  TrackPoint<Real> operator()(int i) const {
    const segcal_point_t& p = points[i];
    return {p.track_id, p.camera, Vec2<Real>(Real(p.u), Real(p.v))};
  }
};

}  // namespace
}  // namespace SEGCAL_NS

using namespace SEGCAL_NS;

extern "C" {

uint32_t segcal_version(void) { return SEGCAL_VERSION; }

int segcal_push_imu(segcal_t* device, const segcal_imu_t* sample) {
  if (!sample) return SEGCAL_ERROR_NULL;
  CDevice* d = open(device);
  if (!d) return SEGCAL_ERROR_STATE;
  InertialReading<Real> reading;
  for (int i = 0; i < 3; ++i) {
    reading.gyro(i) = Real(sample->gyro[i]);
    reading.accel(i) = Real(sample->accel[i]);
  }
  return code(d->device.push_imu(sample->t_ns, reading, Real(sample->temperature)));
}

int segcal_push_tracks(segcal_t* device, int64_t t_ns, const segcal_point_t* points, int32_t n) {
  CDevice* d = open(device);
  if (!d) return SEGCAL_ERROR_STATE;
  const int error = check_points(*d, points, n);
  if (error != SEGCAL_OK) return error;
  return code(d->device.push_tracks(t_ns, n, PointReader{points}));
}

int segcal_push_keyframe(segcal_t* device, const segcal_state_t* state, const segcal_point_t* points, int32_t n) {
  if (!state) return SEGCAL_ERROR_NULL;
  CDevice* d = open(device);
  if (!d) return SEGCAL_ERROR_STATE;
  const int error = check_points(*d, points, n);
  if (error != SEGCAL_OK) return error;
  State<Real> x;
  if (!state_from_c(*state, &x)) return SEGCAL_ERROR_NOT_FINITE;
  for (int32_t i = 0; i < n; ++i) {
    if (!is_finite(points[i].u) || !is_finite(points[i].v)) return SEGCAL_ERROR_NOT_FINITE;
  }
  return code(d->device.push_keyframe(state->t_ns, x, state->p_GI, n, PointReader{points}));
}

int segcal_background(segcal_t* device, int32_t slices) {
  CDevice* d = open(device);
  if (!d) return SEGCAL_ERROR_STATE;
  if (slices < 0) return SEGCAL_ERROR_SIZE;
  return d->device.background(slices);
}

int segcal_work_when_due(segcal_t* device, int32_t on) {
  CDevice* d = open(device);
  if (!d) return SEGCAL_ERROR_STATE;
  d->device.work_when_due(on != 0);
  return SEGCAL_OK;
}

int segcal_progress(const segcal_t* device, segcal_progress_t* out) {
  if (!out) return SEGCAL_ERROR_NULL;
  const CDevice* d = open(device);
  if (!d) return SEGCAL_ERROR_STATE;
  const Device<Real>& x = d->device;
  const SliceCounts& n = x.slices();
  const bool scoring = x.scoring(), calibrating = x.calibrating();
  *out = {x.start_pending() ? SEGCAL_WORK_START
          : scoring         ? SEGCAL_WORK_SCORE
          : calibrating     ? SEGCAL_WORK_CALIBRATION
                            : SEGCAL_WORK_NONE,
          x.ends_left(),
          scoring || calibrating ? n.job : 0,
          scoring       ? n.score
          : calibrating ? n.calibration
                        : 0,
          n.all,
          x.faults().slices_late};
  return SEGCAL_OK;
}

int segcal_request_calibration(segcal_t* device) {
  CDevice* d = open(device);
  if (!d) return SEGCAL_ERROR_STATE;
  d->device.request_calibration();
  return SEGCAL_OK;
}

int segcal_flush_slices(segcal_t* device, int32_t slices) {
  CDevice* d = open(device);
  if (!d) return SEGCAL_ERROR_STATE;
  if (slices < 0) return SEGCAL_ERROR_SIZE;
  for (; slices > 0; --slices) {
    if (!d->device.flush_step()) return 0;
  }
  return 1;
}

int segcal_flush(segcal_t* device) {
  CDevice* d = open(device);
  if (!d) return SEGCAL_ERROR_STATE;
  d->device.flush();
  return SEGCAL_OK;
}

int segcal_new_session(segcal_t* device) {
  CDevice* d = open(device);
  if (!d) return SEGCAL_ERROR_STATE;
  d->device.new_session();
  return SEGCAL_OK;
}

int segcal_calibrate(segcal_t* device) {
  CDevice* d = open(device);
  if (!d) return SEGCAL_ERROR_STATE;
  d->device.calibrate();
  return d->device.report().release.status == Status::calibrated ? SEGCAL_OK : SEGCAL_NO_RESULT;
}

}  // extern "C"
