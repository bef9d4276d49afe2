// What the report draws, thinned to what a screen can show.
#include "replay/result_files.h"

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

Json residuals_json(const ReplayResult& out, std::int64_t start) {
  std::size_t total = 0;
  for (const CoreKept& k : out.kept) total += k.points.size();
  const std::size_t every = total / 4000 + 1;
  Json camera = Json::array();
  Json t = Json::array(), rotation = Json::array(), velocity = Json::array(), position = Json::array();
  for (const CoreKept& k : out.kept) {
    for (std::size_t i = 0; i < k.points.size(); i += every) {
      const CorePointResidual& r = k.points[i];
      camera.push_back({{"t", seconds(r.t_ns, start)}, {"camera", r.camera}, {"u_sigma", r.u_sigma}, {"v_sigma", r.v_sigma}});
    }
    for (const CoreImuResidual& r : k.imu) {
      t.push_back(seconds(r.t_ns, start));
      rotation.push_back(triple(r.rotation));
      velocity.push_back(triple(r.velocity));
      position.push_back(triple(r.position));
    }
  }
  return {{"camera", camera}, {"imu", {{"t", t}, {"rotation", rotation}, {"velocity", velocity}, {"position", position}}}};
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
  json["segments"] = Json::array();
  for (const CoreSegment& s : out.segments) {
    json["segments"].push_back({{"start_s", seconds(s.start_ns, start)}, {"end_s", seconds(s.end_ns, start)}, {"A", s.A},
                                {"D", s.D}, {"E", s.E}, {"kept", s.kept}});
  }
  json["residuals"] = residuals_json(out, start);
  json["biases"] = biases_json(out, start);
  if (!truth.empty()) json["truth"] = truth_json(truth, start);
  json["faults"] = Json::object();
  for (const auto& [name, count] : out.counters) json["faults"][name] = count;
  return json;
}

}  // namespace host
