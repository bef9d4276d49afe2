// The C structures of one profile in the host's own.
#include "replay/profile/read_device.h"

namespace host {
namespace SEGCAL_NS {

CoreState state_of(const segcal_state_t& s) {
  CoreState out;
  out.t_ns = s.t_ns;
  for (int i = 0; i < 4; ++i) out.q_GI_wxyz(i) = s.q_GI[i];
  for (int i = 0; i < 3; ++i) {
    out.p_GI(i) = s.p_GI[i];
    out.v_GI(i) = s.v_GI[i];
    out.b_a(i) = s.b_a[i];
    out.b_g(i) = s.b_g[i];
  }
  return out;
}

CoreSegment segment_of(const segcal_segment_t& s) {
  CoreSegment out;
  out.start_ns = s.start_ns;
  out.end_ns = s.end_ns;
  out.session = s.session;
  out.serial = s.serial;
  out.keyframes = s.keyframes;
  out.landmarks = s.landmarks;
  out.points = s.points;
  out.rank = s.rank;
  out.A = s.A;
  out.D = s.D;
  out.E = s.E;
  out.gain_nats = s.gain_nats;
  out.kept = s.kept != 0;
  out.settled = s.settled != 0;
  return out;
}

CoreDirection direction_of(const segcal_direction_t& d, int n) {
  return {std::vector<double>(d.weight, d.weight + n), d.relative_sigma};
}

CoreEpoch epoch_of(const segcal_epoch_t& e) {
  return {e.segments,
          e.first_session,
          e.last_session,
          {e.value, e.value + e.n_parameters},
          {e.sigma, e.sigma + e.n_parameters}};
}

CoreCourse course_of(const segcal_course_t& c) {
  CoreCourse out;
  for (unsigned f = 0; f < course_names.size(); ++f) {
    out.ln_odds[f] = c.ln_odds[f];
    if ((c.courses & 1u << f) != 0) out.courses.push_back(course_names[f]);
    if (c.rate_of == 1u << f) out.rate_of = course_names[f];
  }
  out.sessions = c.sessions;
  out.step_session = c.step_session;
  out.rate.assign(c.rate, c.rate + c.n_parameters);
  out.sigma.assign(c.sigma, c.sigma + c.n_parameters);
  return out;
}

/// What the device remembers of segments that are kept no longer.
void read_memory(segcal_t* device, CoreResult* out) {
  segcal_epoch_t e;
  for (int i = 0; segcal_get_epoch(device, i, &e) == SEGCAL_OK; ++i) {
    if (e.segments > 0) out->epochs.push_back(epoch_of(e));  // else it has just begun
  }
  for (int i = 0; segcal_get_history(device, i, &e) == SEGCAL_OK; ++i)
    out->history.push_back({epoch_of(e), e.temperature_degC, e.changes});
  segcal_course_t course;
  if (segcal_get_course(device, &course) == SEGCAL_OK) out->course = course_of(course);
  segcal_change_t c;
  for (int i = -1; i == -1 || segcal_get_change(device, i, &c) == SEGCAL_OK; ++i) {
    if (i == -1 && segcal_get_change(device, i, &c) != SEGCAL_OK) continue;
    out->changes.insert(out->changes.begin(), {c.open != 0,
                                               c.before_session,
                                               c.after_session,
                                               c.t_ns,
                                               {c.step, c.step + c.n_parameters},
                                               {c.sigma, c.sigma + c.n_parameters}});
  }
}

CoreResult result_of(segcal_t* device) {
  segcal_result_t r;
  CoreResult out;
  if (segcal_get_result(device, &r) != SEGCAL_OK) return out;
  static const char* const kStatus[] = {"insufficient", "calibrated", "failed"};
  static const char* const kVerdict[] = {"fixed", "weak", "observed"};
  out.status = kStatus[r.status];
  for (int i = 0; i < r.n_parameters; ++i) {
    const segcal_parameter_t& p = r.parameter[i];
    out.parameters.push_back({p.name, p.unit, kVerdict[p.verdict], p.value, p.initial, p.sigma, p.prior_sigma});
  }
  for (int i = 0; i < r.n_directions; ++i) {
    segcal_direction_t d;
    if (segcal_get_direction(device, i, &d) == SEGCAL_OK) out.unobservable.push_back(direction_of(d, r.n_parameters));
  }
  out.iterations = r.iterations;
  out.segments = r.segments;
  out.partitions = r.partitions;
  out.image_points = r.image_points;
  out.converged = r.converged != 0;
  out.chi2 = r.chi2;
  out.dof = r.dof;
  out.noise_scale = r.noise_scale;
  out.reprojection_rms_px = r.reprojection_rms_px;
  out.reprojection_median_px = r.reprojection_median_px;
  const std::size_t n = out.parameters.size();
  out.mean.resize(n);
  out.covariance.resize(n * n);
  if (segcal_get_posterior(device, out.mean.data(), out.covariance.data(), static_cast<int>(n * n)) < 0) {
    out.mean.clear();
    out.covariance.clear();
  }
  read_memory(device, &out);
  return out;
}

/// What the calibration had of a segment.
static void add_measurements(const segcal_t* device, int slot, const segcal_segment_t& s, CoreKept* kept) {
  segcal_link_t link{};
  if (segcal_get_link(device, slot, &link) == SEGCAL_OK) {
    static const char* const kJoin[] = {"none", "imu", "bias"};
    kept->place = link.place;
    kept->join = kJoin[link.join];
    kept->gap_s = link.gap_s;
    kept->lead_ns = link.lead_ns;
    kept->turned_only = link.turned_only != 0;
  }
  std::vector<segcal_landmark_t> landmarks(s.landmarks);
  landmarks.resize(std::max(0, segcal_get_landmarks(device, slot, landmarks.data(), s.landmarks)));
  for (const segcal_landmark_t& l : landmarks) {
    kept->landmarks.push_back({l.track_id, l.tie, Eigen::Vector3d(l.anchor[0], l.anchor[1], l.anchor[2]),
                               Eigen::Vector3d(l.direction[0], l.direction[1], l.direction[2]), l.inverse_distance});
  }
  std::vector<segcal_measured_point_t> points(s.points);
  points.resize(std::max(0, segcal_get_points(device, slot, points.data(), s.points)));
  for (const segcal_measured_point_t& z : points) {
    kept->measured.push_back({z.landmark, z.keyframe, z.camera, z.u, z.v, z.rejected != 0});
  }
  std::vector<segcal_imu_t> samples(SEGCAL_MAX_IMU_SAMPLES);
  samples.resize(std::max(0, segcal_get_samples(device, slot, samples.data(), SEGCAL_MAX_IMU_SAMPLES)));
  for (const segcal_imu_t& z : samples) {
    kept->samples.push_back({z.t_ns, {z.gyro[0], z.gyro[1], z.gyro[2]}, {z.accel[0], z.accel[1], z.accel[2]}, 0});
  }
}

CoreKept kept_of(const segcal_t* device, int slot, const segcal_segment_t& s) {
  CoreKept kept;
  kept.segment = segment_of(s);
  std::vector<segcal_state_t> states(s.keyframes);
  states.resize(std::max(0, segcal_get_keyframes(device, slot, states.data(), s.keyframes)));
  for (const segcal_state_t& x : states) kept.keyframes.push_back(state_of(x));
  std::vector<segcal_point_residual_t> points(s.points);
  points.resize(std::max(0, segcal_get_point_residuals(device, slot, points.data(), s.points)));
  for (const segcal_point_residual_t& r : points) kept.points.push_back({r.t_ns, r.camera, r.u, r.v});
  std::vector<segcal_imu_residual_t> imu(s.keyframes);
  imu.resize(std::max(0, segcal_get_imu_residuals(device, slot, imu.data(), s.keyframes)));
  for (const segcal_imu_residual_t& r : imu) {
    kept.imu.push_back({r.t_ns, Eigen::Vector3d(r.rotation[0], r.rotation[1], r.rotation[2]),
                        Eigen::Vector3d(r.velocity[0], r.velocity[1], r.velocity[2]),
                        Eigen::Vector3d(r.position[0], r.position[1], r.position[2])});
  }
  add_measurements(device, slot, s, &kept);
  return kept;
}

std::vector<std::pair<std::string, std::uint32_t>> counters_of(const segcal_t* device) {
  segcal_counters_t c;
  segcal_get_counters(device, &c);
  return {{"imu_samples", c.imu_samples},
          {"imu_stamps_back", c.imu_stamps_back},
          {"imu_gaps", c.imu_gaps},
          {"imu_not_finite", c.imu_not_finite},
          {"imu_saturated", c.imu_saturated},
          {"frames", c.frames},
          {"frames_used", c.frames_used},
          {"frame_stamps_back", c.frame_stamps_back},
          {"frames_dropped", c.frames_dropped},
          {"frames_few_tracks", c.frames_few_tracks},
          {"points_not_finite", c.points_not_finite},
          {"filter_restarts", c.filter_restarts},
          {"standstill_frames", c.standstill_frames},
          {"features_used", c.features_used},
          {"features_gated", c.features_gated},
          {"segments_closed", c.segments_closed},
          {"segments_discarded", c.segments_discarded},
          {"segments_unsettled", c.segments_unsettled},
          {"segments_ended_early", c.segments_ended_early},
          {"landmarks_left_out", c.landmarks_left_out},
          {"points_left_out", c.points_left_out},
          {"segments_outdated", c.segments_outdated},
          {"segments_missed", c.segments_missed},
          {"slices_late", c.slices_late},
          {"segments_late", c.segments_late},
          {"imu_spikes", c.imu_spikes},
          {"calibrations", c.calibrations},
          {"points_repeated", c.points_repeated},
          {"imu_stamps_far", c.imu_stamps_far},
          {"frame_stamps_far", c.frame_stamps_far},
          {"clock_restarts", c.clock_restarts}};
}

}  // namespace SEGCAL_NS
}  // namespace host
