// What the report draws, thinned to what a screen can show.
#include <cmath>

#include "replay/result_files.h"
#include "replay/track_residuals.h"

namespace host {
namespace {

using Json = nlohmann::ordered_json;

Json triple(const Eigen::Vector3d& v) { return Json::array({v.x(), v.y(), v.z()}); }

double seconds(std::int64_t t_ns, std::int64_t start_ns) { return static_cast<double>(t_ns - start_ns) * 1e-9; }

int kept_index(const std::vector<CoreKept>& kept, std::int64_t t_ns) {
  for (std::size_t i = 0; i < kept.size(); ++i) {
    if (t_ns >= kept[i].segment.start_ns && t_ns <= kept[i].segment.end_ns) return static_cast<int>(i);
  }
  return -1;
}

Json trajectory_json(const ReplayResult& out, std::int64_t start) {
  Json t = Json::array(), p = Json::array(), kept = Json::array();
  for (const CoreState& s : out.trajectory) {
    t.push_back(seconds(s.t_ns, start));
    p.push_back(triple(s.p_GI));
    kept.push_back(kept_index(out.kept, s.t_ns));
  }
  return {{"t", t}, {"p", p}, {"kept", kept}};
}

Json biases_json(const ReplayResult& out, std::int64_t start) {
  Json t = Json::array(), gyro = Json::array(), accel = Json::array();
  for (const CoreState& s : out.trajectory) {
    t.push_back(seconds(s.t_ns, start));
    gyro.push_back(triple(s.b_g));
    accel.push_back(triple(s.b_a));
  }
  return {{"t", t}, {"gyro", gyro}, {"accel", accel}};
}

/// To one part in `parts`: digits that no screen shows make the file three times as long.
double rounded(double value, double parts) { return std::round(value * parts) / parts; }

using Tracks = std::vector<std::vector<TrackResidual>>;

/// One column per quantity: an object per point is four times as long.
/// Tracks are left out whole, so that the others can be followed.
Json camera_json(const ReplayResult& out, std::int64_t start) {
  constexpr std::size_t kMostPoints = 12000;
  Tracks tracks;
  std::size_t total = 0;
  for (const CoreKept& k : out.kept) {
    for (auto& [key, points] : tracks_of_segment(k)) {
      total += points.size();
      tracks.push_back(std::move(points));
    }
  }
  const std::size_t every = total / kMostPoints + 1;
  Json columns = Json::object();
  for (const char* name : {"t", "camera", "track", "u", "v", "u_px", "v_px", "u_sigma", "v_sigma"})
    columns[name] = Json::array();
  for (std::size_t i = 0; i < tracks.size(); i += every) {
    const std::vector<Eigen::Vector2d> r_px = residuals_px(tracks[i], out.model);
    for (std::size_t n = 0; n < tracks[i].size(); ++n) {
      const auto& [z, residual] = tracks[i][n];
      columns["t"].push_back(rounded(seconds(residual->t_ns, start), 1e3));
      columns["camera"].push_back(z->camera);
      columns["track"].push_back(i);
      columns["u"].push_back(rounded(z->u, 1e2));
      columns["v"].push_back(rounded(z->v, 1e2));
      columns["u_px"].push_back(rounded(r_px[n].x(), 1e4));
      columns["v_px"].push_back(rounded(r_px[n].y(), 1e4));
      columns["u_sigma"].push_back(rounded(residual->u_sigma, 1e4));
      columns["v_sigma"].push_back(rounded(residual->v_sigma, 1e4));
    }
  }
  return columns;
}

Json imu_json(const ReplayResult& out, std::int64_t start) {
  Json t = Json::array(), rotation = Json::array(), velocity = Json::array(), position = Json::array();
  for (const CoreKept& k : out.kept) {
    for (const CoreImuResidual& r : k.imu) {
      t.push_back(seconds(r.t_ns, start));
      rotation.push_back(triple(r.rotation));
      velocity.push_back(triple(r.velocity));
      position.push_back(triple(r.position));
    }
  }
  return {{"t", t}, {"rotation", rotation}, {"velocity", velocity}, {"position", position}};
}

/// log2(prior sigma / sigma) of each parameter, from the segment and the prior alone: each bit halves the sigma.
Json told_bits(const CoreSegment& s, const std::vector<CoreParameter>& parameters) {
  Json bits = Json::array();
  if (s.sigma.size() != parameters.size()) return bits;
  for (std::size_t i = 0; i < parameters.size(); ++i)
    bits.push_back(rounded(std::log2(parameters[i].prior_sigma / s.sigma[i]), 1e3));
  return bits;
}

Json segments_json(const ReplayResult& out, std::int64_t start) {
  Json json = Json::array();
  for (const CoreSegment& s : out.segments) {
    json.push_back({{"start_s", seconds(s.start_ns, start)},
                    {"end_s", seconds(s.end_ns, start)},
                    {"A", s.A},
                    {"D", s.D},
                    {"E", s.E},
                    {"kept", s.kept},
                    {"told_bits", told_bits(s, out.result.parameters)}});
  }
  return json;
}

Json images_json(const ReplayResult& out) {
  Json json = Json::array();
  for (const CameraCalibration& camera : out.calibration.cameras) json.push_back({camera.width, camera.height});
  return json;
}

Json truth_json(const std::vector<TruthPose>& truth, std::int64_t start) {
  Json t = Json::array(), p = Json::array();
  const std::size_t every = truth.size() / 3000 + 1;
  for (std::size_t i = 0; i < truth.size(); i += every) {
    t.push_back(seconds(truth[i].t_ns, start));
    p.push_back(Json::array({truth[i].p_GI[0], truth[i].p_GI[1], truth[i].p_GI[2]}));
  }
  return {{"t", t}, {"p", p}};
}

}  // namespace

Json report_data(const ReplayResult& out, const std::vector<TruthPose>& truth) {
  const std::int64_t start = out.trajectory.empty() ? 0 : out.trajectory.front().t_ns;
  Json json;
  json["start_ns"] = start;
  json["trajectory"] = trajectory_json(out, start);
  json["segments"] = segments_json(out, start);
  json["images"] = images_json(out);
  json["residuals"] = {{"camera", camera_json(out, start)}, {"imu", imu_json(out, start)}};
  json["biases"] = biases_json(out, start);
  if (!truth.empty()) json["truth"] = truth_json(truth, start);
  json["faults"] = Json::object();
  for (const auto& [name, count] : out.counters) json["faults"][name] = count;
  return json;
}

}  // namespace host
