// What `segcal diagnose --out DIR` leaves: the answer, the model, the header for firmware, and what the report draws.
#include "diagnose/diagnosis_files.h"

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>

#include "files/output_run.h"
#include "replay/model_file.h"
#include "replay/track_residuals.h"

namespace host {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kWorstWindows = 4;

/// Mean squares of one segment's residuals.
struct SegmentError {
  const CoreKept* kept = nullptr;
  double camera = 0;
};

double camera_square(const CoreKept& k) {
  double sum = 0;
  for (const CorePointResidual& r : k.points) sum += r.u_sigma * r.u_sigma + r.v_sigma * r.v_sigma;
  return k.points.empty() ? 0 : sum / (2.0 * static_cast<double>(k.points.size()));
}

/// A stretch of time. Two fits need not cut the time into the same segments: it is looked up in all of each.
struct Stretch {
  std::int64_t start_ns, end_ns, zero_ns;
  bool holds(std::int64_t t_ns) const { return t_ns >= start_ns && t_ns <= end_ns; }
  double seconds(std::int64_t t_ns) const { return 1e-9 * static_cast<double>(t_ns - zero_ns); }
};

/// Mean over the points of each keyframe, px, and the IMU's whitened residuals.
Json window_json(const ReplayResult& fit, const Stretch& stretch) {
  std::map<std::int64_t, std::array<double, 3>> image;  // sums and count
  std::map<std::int64_t, const CoreImuResidual*> imu;
  for (const CoreKept& k : fit.kept) {
    const std::vector<Eigen::Vector2d> r_px = residuals_px(k, fit.model);
    for (std::size_t i = 0; i < k.points.size(); ++i) {
      if (!stretch.holds(k.points[i].t_ns)) continue;
      auto& sum = image[k.points[i].t_ns];
      sum[0] += r_px[i].x();
      sum[1] += r_px[i].y();
      sum[2] += 1;
    }
    for (const CoreImuResidual& r : k.imu) {
      if (stretch.holds(r.t_ns)) imu[r.t_ns] = &r;
    }
  }
  Json t = Json::array(), u = Json::array(), v = Json::array(), ti = Json::array(), gyro = Json::array(),
       accel = Json::array();
  for (const auto& [t_ns, sum] : image) {
    t.push_back(stretch.seconds(t_ns));
    u.push_back(sum[0] / sum[2]);
    v.push_back(sum[1] / sum[2]);
  }
  for (const auto& [t_ns, r] : imu) {
    ti.push_back(stretch.seconds(t_ns));
    gyro.push_back({r->rotation.x(), r->rotation.y(), r->rotation.z()});
    accel.push_back({r->velocity.x(), r->velocity.y(), r->velocity.z()});
  }
  return {{"t", t}, {"u_px", u}, {"v_px", v}, {"t_imu", ti}, {"gyro", gyro}, {"accel", accel}};
}

/// One corner's measured and simulated image points in a stretch, in order of time.
struct Track {
  std::map<std::int64_t, std::array<double, 4>> points;
  double square = 0;
};

std::map<std::uint32_t, Track> tracks_of(const ReplayResult& fit, const Stretch& stretch) {
  std::map<std::uint32_t, Track> out;
  for (const CoreKept& k : fit.kept) {
    const std::vector<Eigen::Vector2d> r_px = residuals_px(k, fit.model);
    for (const diagnosis::SeenPoint& s : diagnosis::seen_points(k)) {
      if (!stretch.holds(s.residual->t_ns) || s.point->camera != 0) continue;
      const Eigen::Vector2d& r = r_px[static_cast<std::size_t>(s.residual - k.points.data())];
      Track& track = out[k.landmarks[s.point->landmark].track_id];
      track.square += r.squaredNorm();
      track.points[s.residual->t_ns] = {s.point->u, s.point->v, s.point->u + r.x(), s.point->v + r.y()};
    }
  }
  return out;
}

/// The long track whose residuals are largest; 0: there is none.
std::uint32_t worst_track(const ReplayResult& fit, const Stretch& stretch) {
  std::uint32_t worst = 0;
  double most = 0;
  for (const auto& [id, track] : tracks_of(fit, stretch)) {
    if (track.points.size() < 8 || track.square <= most) continue;
    most = track.square;
    worst = id;
  }
  return worst;
}

Json track_json(const ReplayResult& fit, const Stretch& stretch, std::uint32_t id) {
  Json measured = Json::array(), simulated = Json::array();
  const auto tracks = tracks_of(fit, stretch);
  const auto track = tracks.find(id);
  if (track != tracks.end()) {
    for (const auto& [t_ns, p] : track->second.points) {
      measured.push_back({p[0], p[1]});
      simulated.push_back({p[2], p[3]});
    }
  }
  return {{"track_id", id}, {"measured", measured}, {"simulated", simulated}};
}

Json windows_json(const Diagnosis& d, std::int64_t zero_ns) {
  std::vector<SegmentError> order;
  for (const CoreKept& k : d.fit_before.kept) order.push_back({&k, camera_square(k)});
  std::sort(order.begin(), order.end(),
            [](const SegmentError& a, const SegmentError& b) { return a.camera > b.camera; });
  Json out = Json::array();
  for (std::size_t i = 0; i < std::min(kWorstWindows, order.size()); ++i) {
    const CoreSegment& segment = order[i].kept->segment;
    const Stretch stretch{segment.start_ns, segment.end_ns, zero_ns};
    const std::uint32_t track = worst_track(d.fit_before, stretch);
    Json window = {{"start_s", stretch.seconds(stretch.start_ns)}, {"end_s", stretch.seconds(stretch.end_ns)}};
    window["before"] = window_json(d.fit_before, stretch);
    window["track_before"] = track_json(d.fit_before, stretch, track);
    if (!d.fit_after.kept.empty()) {
      window["after"] = window_json(d.fit_after, stretch);
      window["track_after"] = track_json(d.fit_after, stretch, track);
    }
    out.push_back(window);
  }
  return out;
}

Json causes_json(const std::vector<diagnosis::Structure>& structure) {
  Json out = Json::array();
  for (const diagnosis::Structure& s : structure) {
    out.push_back({{"sensor", s.sensor},
                   {"axis", s.axis},
                   {"against", s.against},
                   {"unit", s.unit},
                   {"cause", s.bin_cause},
                   {"mean", s.bin_mean},
                   {"sigma", s.bin_sigma}});
  }
  return out;
}

}  // namespace

std::string diagnosis_data_json(const Diagnosis& d, const std::vector<Recording>& sessions) {
  const std::vector<Frame>& frames = sessions.front().cameras.front().frames;
  const std::int64_t zero_ns = frames.empty() ? 0 : frames.front().t_ns;
  Json json = {{"windows", windows_json(d, zero_ns)},
               {"causes_before", causes_json(d.where)},
               {"causes_after", causes_json(d.left)}};
  return json.dump();
}

void write_diagnosis(const std::filesystem::path& folder, const Diagnosis& d, const std::vector<Recording>& sessions,
                     const std::vector<std::pair<std::string, std::string>>& beside) {
  OutputRun run(folder, "diagnose");
  const ReplayResult& last = d.fit_after.kept.empty() ? d.fit_before : d.fit_after;
  if (!last.calibration.cameras.empty()) {
    write_camchain(folder / "camchain-imucam.yaml", last.calibration);
    write_imu_yaml(folder / "imu.yaml", last.calibration, d.noise);
  }
  write_file(folder / "model.yaml",
             model_yaml(d.model.empty() ? d.fit_before : last));  // what got no name is not in it
  write_file(folder / "segcal_effects.h", effects_header(d));
  write_file(folder / "diagnosis_data.json", diagnosis_data_json(d, sessions));
  for (const auto& [name, text] : beside) write_file(folder / name, text);
  write_file(folder / "diagnosis.json", diagnosis_json(d) + "\n");
  run.finish();
}

}  // namespace host
