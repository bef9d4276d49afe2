// A recording's twin without effects: its motion, scene, corners and sensors.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "diagnose/rest.h"
#include "quantile.h"
#include "twin/make.h"
#include "twin/motion.h"

namespace host::twin {
namespace {

constexpr double nearest_m = 0.05, farthest_m = 50;  ///< m; the latter for landmarks without parallax
constexpr std::size_t fewest_landmarks = 200;
constexpr int shortest_life = 3;    ///< images
constexpr int life_rounds = 3;      ///< the twin's lives are within some per cent then
constexpr double most_longer = 10;  ///< times: a scene that is seen for moments only

Eigen::Isometry3d pose_of(const CoreState& x) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = Eigen::Quaterniond(x.q_GI_wxyz[0], x.q_GI_wxyz[1], x.q_GI_wxyz[2], x.q_GI_wxyz[3])
                   .normalized()
                   .toRotationMatrix();
  T.translation() = x.p_GI;
  return T;
}

/// Each segment has a world of its own: its landmarks are put where they stand as seen from the odometry's pose at its
/// first keyframe.
std::vector<Eigen::Vector3d> landmarks_of(const ReplayResult& fit, std::int64_t first_ns, std::int64_t last_ns) {
  std::map<std::int64_t, const CoreState*> odometry;
  for (const CoreState& x : fit.trajectory) odometry[x.t_ns] = &x;
  std::vector<Eigen::Vector3d> out;
  for (const CoreKept& kept : fit.kept) {
    if (kept.keyframes.empty() || kept.keyframes.front().t_ns < first_ns || kept.keyframes.back().t_ns > last_ns)
      continue;
    const auto at = odometry.find(kept.keyframes.front().t_ns);
    if (at == odometry.end()) continue;
    const Eigen::Isometry3d T = pose_of(*at->second) * pose_of(kept.keyframes.front()).inverse();
    for (const CoreLandmark& l : kept.landmarks)
      out.push_back(T * (l.anchor + l.direction / std::max(l.inverse_distance, 1 / farthest_m)));
  }
  return out;
}

/// Of tracks that live for three images and more: what is shorter tells nothing.
std::vector<int> lives_of(const CameraData& camera) {
  std::map<std::uint32_t, int> life;
  for (const Frame& frame : camera.frames)
    for (const TrackPoint& p : frame.points) ++life[p.track_id];
  std::vector<int> out;
  for (const auto& [id, frames] : life)
    if (frames >= shortest_life) out.push_back(frames);
  return out;
}

double mean_of(const std::vector<int>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) /
         static_cast<double>(std::max<std::size_t>(values.size(), 1));
}

/// As many corners at a time as the recording has, and that live as long. Recorded lives end at the image's edge, too:
/// drawn as they are they would end there once more, and are made longer until the twin's are as long.
void follow_tracks(const CameraData& camera, SimulationOptions* out) {
  double points = 0;
  for (const Frame& frame : camera.frames) points += static_cast<double>(frame.points.size());
  out->tracks.shortest = shortest_life;
  out->tracks.count = std::max(1, static_cast<int>(std::lround(points / static_cast<double>(camera.frames.size()))));
  out->tracks.depth = {nearest_m, 2 * farthest_m};
  const std::vector<int> lives = lives_of(camera);
  double longer = 1;
  for (int round = 0; round < life_rounds && !lives.empty(); ++round) {
    out->tracks.lives = lives;
    for (int& life : out->tracks.lives) life = static_cast<int>(std::lround(longer * life));
    const double twins = mean_of(lives_of(simulate(*out).recording.cameras.front()));
    if (twins > 0) longer = std::clamp(longer * mean_of(lives) / twins, 1.0, most_longer);
  }
}

double images_per_s(const CameraData& camera) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < camera.frames.size(); ++i)
    steps.push_back(1e-9 * static_cast<double>(camera.frames[i].t_ns - camera.frames[i - 1].t_ns));
  return 1 / quantile(steps, 0.5);
}

/// Motion and scene.
sim::Replica replica_of(const Recording& session, const ReplayResult& fit) {
  sim::Replica out;
  out.poses = motion_of(session, fit);
  if (out.poses.t.empty()) throw InputError("the odometry does not run for three seconds without a break");
  const std::int64_t first_ns = out.poses.first_ns;
  out.landmarks_G = landmarks_of(fit, first_ns, first_ns + static_cast<std::int64_t>(1e9 * out.poses.t.back()));
  if (out.landmarks_G.size() < fewest_landmarks)
    throw InputError("the kept segments hold " + std::to_string(out.landmarks_G.size()) +
                     " landmarks, of 200 that a scene needs");
  return out;
}

/// What the recording says beside: temperatures and exposures.
void take_conditions(const Recording& session, sim::Replica* out) {
  const auto seconds = [first_ns = out->poses.first_ns](std::int64_t t_ns) {
    return 1e-9 * static_cast<double>(t_ns - first_ns);
  };
  using Values = std::vector<std::pair<double, double>>;
  const auto add = [&seconds](std::int64_t t_ns, double value, Values* values) {
    const bool later = values->empty() || seconds(t_ns) > values->back().first;  // faulty stamps go back
    if (later) values->emplace_back(seconds(t_ns), value);
  };
  for (const Frame& frame : session.cameras.front().frames)
    if (frame.exposure_s > 0) add(frame.t_ns, frame.exposure_s, &out->exposures_s);
  if (!session.imu.has_temperature) return;
  for (const ImuSample& s : session.imu.samples) add(s.t_ns, s.temperature_degC, &out->temperatures_degC);
}

}  // namespace

SimulationOptions plain_twin(const Recording& session, const Diagnosis& found, const DiagnoseOptions& options) {
  const ReplayResult& fit = last_fit(found);
  sim::Replica replica = replica_of(session, fit);
  take_conditions(session, &replica);
  replica.device = fit.calibration;
  replica.start = options.core.calibration;
  for (Calibration* c : {&replica.device, &replica.start})
    for (CameraCalibration& camera : c->cameras) camera.timeshift_cam_imu = 0;
  put_before_step(found, &replica.device);
  const CameraData& camera = session.cameras.front();
  SimulationOptions out;
  out.cameras = static_cast<int>(replica.device.cameras.size());
  out.seconds = std::max(1.0, replica.poses.t.back());
  out.camera_rate_hz = std::clamp(images_per_s(camera), 1.0, 200.0);
  out.imu_noise = session.imu.noise;
  out.imu_noise.rate_hz = std::clamp(median_rate_hz(session.imu.samples), 50.0, 4000.0);
  out.tracks.pixel_noise_px = options.core.pixel_sigma;
  out.replica = std::move(replica);
  follow_tracks(camera, &out);
  return out;
}

}  // namespace host::twin
