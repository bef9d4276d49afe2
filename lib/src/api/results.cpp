// The C API's answers: state, calibration, verdicts, segments, counters.
#include "api/handle.h"

namespace SEGCAL_NS {
namespace {

/// Direction i of an analysis, scaled so that its largest weight is 1.
void direction_to_c(const Directions<Real>& a, int i, segcal_direction_t* out) {
  Real largest = Real(0);
  for (int j = 0; j < a.n; ++j) {
    const Real v = a.V[j * a.n + i];
    if (absolute(v) > absolute(largest)) largest = v;
  }
  for (int j = 0; j < SEGCAL_MAX_PARAMETERS; ++j) {
    out->weight[j] = j < a.n && largest != Real(0) ? static_cast<double>(a.V[j * a.n + i] / largest) : 0;
  }
  out->relative_sigma = static_cast<double>(a.relative_sigma(i));
}

/// Index of the nth direction that is not excited, blindest first; -1 if there are fewer.
int unexcited(const Directions<Real>& a, int nth) {
  const int i = a.n - 1 - nth;
  return nth >= 0 && i >= 0 && a.relative_sigma(i) >= ReleaseRules<Real>{}.weak ? i : -1;
}

int count_unexcited(const Directions<Real>& a) {
  int n = 0;
  while (unexcited(a, n) >= 0) ++n;
  return n;
}

/// Parameters and verdicts.
void release_to_c(const CDevice& d, const Release<Real>& release, segcal_result_t* out) {
  out->status = static_cast<int32_t>(release.status);
  out->n_parameters = release.theta.columns();
  out->noise_scale = static_cast<double>(release.noise_scale);
  double value[SEGCAL_MAX_PARAMETERS], initial[SEGCAL_MAX_PARAMETERS];
  parameter_names(release.theta, out->parameter);
  parameter_values(d.device.options().prior.mean, release.theta, value);
  parameter_values(d.device.options().prior.mean, d.device.options().prior.mean, initial);
  for (int i = 0; i < out->n_parameters; ++i) {
    segcal_parameter_t& p = out->parameter[i];
    p.value = value[i];
    p.initial = initial[i];
    p.sigma = static_cast<double>(release.printed_sigma[i]);
    p.prior_sigma = static_cast<double>(d.device.options().prior.sigma[i]);
    p.verdict = static_cast<int32_t>(release.verdict[i]);
  }
}

}  // namespace
}  // namespace SEGCAL_NS

using namespace SEGCAL_NS;

extern "C" {

[[gnu::cold]] int segcal_get_state(const segcal_t* device, segcal_state_t* state) {
  if (!state) return SEGCAL_ERROR_NULL;
  const CDevice* d = open(device);
  if (!d || !d->device.has_state()) return SEGCAL_ERROR_STATE;
  state_to_c(d->device.state(), d->device.origin(), d->device.state_time(), state);
  return SEGCAL_OK;
}

[[gnu::cold]] int segcal_get_camera(const segcal_t* device, int32_t camera, segcal_camera_t* out) {
  if (!out) return SEGCAL_ERROR_NULL;
  const CDevice* d = open(device);
  if (!d) return SEGCAL_ERROR_STATE;
  if (camera < 0 || camera >= d->device.theta().n_cameras) return SEGCAL_ERROR_CAMERA;
  camera_to_c(d->device.theta().camera[camera], out);
  return SEGCAL_OK;
}

[[gnu::cold]] int segcal_get_imu_calibration(const segcal_t* device, segcal_imu_calibration_t* out) {
  if (!out) return SEGCAL_ERROR_NULL;
  const CDevice* d = open(device);
  if (!d) return SEGCAL_ERROR_STATE;
  imu_to_c(d->device.theta().imu, out);
  return SEGCAL_OK;
}

[[gnu::cold]] int segcal_get_result(const segcal_t* device, segcal_result_t* result) {
  if (!result) return SEGCAL_ERROR_NULL;
  const CDevice* d = open(device);
  if (!d || !d->device.has_report()) return SEGCAL_ERROR_STATE;
  const CalibrationReport<Real>& report = d->device.report();
  *result = segcal_result_t{};
  release_to_c(*d, report.release, result);
  result->n_directions = count_unexcited(report.directions);
  if (d->device.options().joint_filter) return SEGCAL_OK;
  result->iterations = report.fit.iterations;
  result->converged = report.fit.converged ? 1 : 0;
  result->segments = report.segments;
  result->partitions = report.partitions;
  result->image_points = report.fit.image_points;
  result->chi2 = static_cast<double>(report.fit.chi2);
  result->dof = static_cast<double>(report.fit.dof);
  result->reprojection_rms_px = static_cast<double>(report.reprojection.rms);
  result->reprojection_median_px = static_cast<double>(report.reprojection.median);
  return SEGCAL_OK;
}

[[gnu::cold]] int segcal_get_filter_calibration(segcal_t* device, segcal_result_t* result) {
  if (!result) return SEGCAL_ERROR_NULL;
  CDevice* d = open(device);
  if (!d) return SEGCAL_ERROR_STATE;
  if (d->device.start_pending()) return SEGCAL_ERROR_BUSY;  // it works in the filter's memory
  Release<Real> release;
  d->device.read_filter(&release);
  *result = segcal_result_t{};
  release_to_c(*d, release, result);
  return SEGCAL_OK;
}

[[gnu::cold]] int segcal_get_direction(const segcal_t* device, int32_t index, segcal_direction_t* direction) {
  if (!direction) return SEGCAL_ERROR_NULL;
  const CDevice* d = open(device);
  if (!d || !d->device.has_report()) return SEGCAL_ERROR_STATE;
  const int i = unexcited(d->device.report().directions, index);
  if (i < 0) return SEGCAL_ERROR_SIZE;
  direction_to_c(d->device.report().directions, i, direction);
  return SEGCAL_OK;
}

[[gnu::cold]] uint64_t segcal_result_hash(const segcal_t* device) {
  const CDevice* d = open(device);
  return d ? d->device.result_hash() : 0;
}

[[gnu::cold]] int segcal_get_segment(const segcal_t* device, int32_t index, segcal_segment_t* out) {
  if (!out) return SEGCAL_ERROR_NULL;
  const CDevice* d = open(device);
  if (!d) return SEGCAL_ERROR_STATE;
  SegmentSummary<Real> s = d->device.last_scored().segment;
  if (index != -1) {
    const bool outdated = index >= 0 && index <= SEGCAL_MAX_SEGMENTS && d->device.database().outdated(index);
    const Segment<Real>* slot = outdated ? &d->device.database().slot(index) : find_slot(*d, index);
    s = slot ? summary_of(*slot) : SegmentSummary<Real>{};
    s.kept = !outdated;
    s.outdated = outdated;
  }
  if (!s.valid) return SEGCAL_ERROR_STATE;
  out->start_ns = s.start_ns;
  out->end_ns = s.end_ns;
  out->session = s.session;
  out->serial = s.serial;
  out->keyframes = s.keyframes;
  out->landmarks = s.landmarks;
  out->points = s.points;
  out->rank = s.metrics.rank;
  out->A = static_cast<double>(s.metrics.A);
  out->D = static_cast<double>(s.metrics.D);
  out->E = static_cast<double>(s.metrics.E);
  out->gain_nats = static_cast<double>(s.metrics.gain);
  out->kept = s.kept ? 1 : 0;
  out->outdated = s.outdated ? 1 : 0;
  out->settled = s.settled ? 1 : 0;
  return SEGCAL_OK;
}

[[gnu::cold]] int segcal_get_segment_directions(const segcal_t* device, segcal_direction_t* out, int32_t capacity) {
  if (!out) return SEGCAL_ERROR_NULL;
  if (capacity < 0) return SEGCAL_ERROR_SIZE;
  const CDevice* d = open(device);
  if (!d || !d->device.last_scored().segment.valid) return SEGCAL_ERROR_STATE;
  int n = 0;
  for (int i; n < capacity && (i = unexcited(d->device.last_scored().directions, n)) >= 0; ++n) {
    direction_to_c(d->device.last_scored().directions, i, &out[n]);
  }
  return n;
}

[[gnu::cold]] int segcal_get_segment_sigmas(const segcal_t* device, double* sigma, int32_t capacity) {
  if (!sigma) return SEGCAL_ERROR_NULL;
  if (capacity < 0) return SEGCAL_ERROR_SIZE;
  const CDevice* d = open(device);
  if (!d || !d->device.last_scored().segment.valid) return SEGCAL_ERROR_STATE;
  const Directions<Real>& a = d->device.last_scored().directions;
  int j = 0;
  for (; j < a.n && j < capacity; ++j) {
    Real sum = Real(0);
    for (int i = 0; i < a.n; ++i) {
      const Real share = a.V[j * a.n + i] * a.relative_sigma(i);
      sum += share * share;
    }
    sigma[j] = static_cast<double>(d->device.options().prior.sigma[j] * square_root(sum));
  }
  return j;
}

[[gnu::cold]] int segcal_get_counters(const segcal_t* device, segcal_counters_t* out) {
  if (!out) return SEGCAL_ERROR_NULL;
  const CDevice* d = open(device);
  if (!d) return SEGCAL_ERROR_STATE;
  const FaultCounts& f = d->device.faults();
  const VioStatistics& v = d->device.vio_statistics();
  const BuilderCounts& b = d->device.builder_counts();
  // clang-format off
  *out = {f.imu_samples, f.imu_stamps_back, f.imu_gaps, f.imu_not_finite, f.imu_saturated, f.frames, f.frames_used,
          f.frame_stamps_back, f.frames_dropped, f.frames_few_tracks, f.points_not_finite, std::uint32_t(v.restarts),
          std::uint32_t(v.standstill_frames), std::uint32_t(v.updates), std::uint32_t(v.gated), f.segments_closed,
          f.segments_discarded, f.segments_unsettled, b.ended_early, b.landmarks_left_out, b.points_left_out,
          f.segments_outdated, f.segments_missed, f.slices_late, f.calibrations, f.points_repeated + b.points_repeated,
          f.imu_stamps_far, f.frame_stamps_far, f.clock_restarts, f.calibrations_published, f.segments_late,
          d->device.imu_spikes()};
  // clang-format on
  return SEGCAL_OK;
}

}  // extern "C"
