// What `segcal diagnose --out DIR` leaves: the answer, the model, the header for firmware, and what the report draws.
#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>

#include "diagnose/diagnosis_files.h"
#include "file_output.h"
#include "replay/model_file.h"

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

/// The segment of the other fit that begins within a tenth of this one's length; null: none, the fits cut the time differently.
const CoreKept* same_time(const std::vector<CoreKept>& kept, const CoreSegment& segment) {
  for (const CoreKept& k : kept) {
    if (10 * std::abs(k.segment.start_ns - segment.start_ns) < segment.end_ns - segment.start_ns) return &k;
  }
  return nullptr;
}

/// Mean over the points of each keyframe, px, and the IMU's whitened residuals.
Json window_json(const CoreKept& k, double pixel_sigma, std::int64_t zero_ns) {
  std::map<std::int64_t, std::array<double, 3>> image;  // sums and count
  for (const CorePointResidual& r : k.points) {
    auto& sum = image[r.t_ns];
    sum[0] += r.u_sigma * pixel_sigma;
    sum[1] += r.v_sigma * pixel_sigma;
    sum[2] += 1;
  }
  Json t = Json::array(), u = Json::array(), v = Json::array(), ti = Json::array(), gyro = Json::array(), accel = Json::array();
  for (const auto& [t_ns, sum] : image) {
    t.push_back(1e-9 * static_cast<double>(t_ns - zero_ns));
    u.push_back(sum[0] / sum[2]);
    v.push_back(sum[1] / sum[2]);
  }
  for (const CoreImuResidual& r : k.imu) {
    ti.push_back(1e-9 * static_cast<double>(r.t_ns - zero_ns));
    gyro.push_back({r.rotation.x(), r.rotation.y(), r.rotation.z()});
    accel.push_back({r.velocity.x(), r.velocity.y(), r.velocity.z()});
  }
  return {{"t", t}, {"u_px", u}, {"v_px", v}, {"t_imu", ti}, {"gyro", gyro}, {"accel", accel}};
}

/// The long track whose residuals are largest, or that of `wanted`: measured and simulated image points.
Json track_json(const CoreKept& k, double pixel_sigma, const Json* wanted = nullptr) {
  std::vector<double> square(k.landmarks.size(), 0);
  std::vector<std::vector<std::array<double, 4>>> points(k.landmarks.size());
  auto residual = k.points.begin();
  for (const CorePoint& p : k.measured) {
    if (residual == k.points.end()) break;
    if (p.rejected || residual->camera != p.camera || residual->t_ns != k.keyframes[p.keyframe].t_ns) continue;
    const double du = residual->u_sigma * pixel_sigma, dv = residual->v_sigma * pixel_sigma;
    ++residual;
    square[p.landmark] += du * du + dv * dv;
    points[p.landmark].push_back({p.u, p.v, p.u + du, p.v + dv});
  }
  std::size_t chosen = wanted ? square.size() : 0;
  for (std::size_t j = 0; j < square.size(); ++j) {
    if (wanted ? k.landmarks[j].track_id == *wanted : points[j].size() >= 8 && square[j] > square[chosen]) chosen = j;
  }
  Json measured = Json::array(), simulated = Json::array();
  if (chosen < points.size()) {
    for (const auto& p : points[chosen]) {
      measured.push_back({p[0], p[1]});
      simulated.push_back({p[2], p[3]});
    }
  }
  return {{"track_id", chosen < k.landmarks.size() ? k.landmarks[chosen].track_id : 0}, {"measured", measured}, {"simulated", simulated}};
}

Json windows_json(const Diagnosis& d, std::int64_t zero_ns) {
  std::vector<SegmentError> order;
  for (const CoreKept& k : d.fit_before.kept) order.push_back({&k, camera_square(k)});
  std::sort(order.begin(), order.end(), [](const SegmentError& a, const SegmentError& b) { return a.camera > b.camera; });
  Json out = Json::array();
  for (std::size_t i = 0; i < std::min(kWorstWindows, order.size()); ++i) {
    const CoreKept& k = *order[i].kept;
    Json window = {{"start_s", 1e-9 * static_cast<double>(k.segment.start_ns - zero_ns)},
                   {"end_s", 1e-9 * static_cast<double>(k.segment.end_ns - zero_ns)},
                   {"before", window_json(k, d.fit_before.model.pixel_sigma, zero_ns)},
                   {"track_before", track_json(k, d.fit_before.model.pixel_sigma)}};
    if (const CoreKept* after = same_time(d.fit_after.kept, k.segment)) {
      window["after"] = window_json(*after, d.fit_after.model.pixel_sigma, zero_ns);
      window["track_after"] = track_json(*after, d.fit_after.model.pixel_sigma, &window["track_before"]["track_id"]);
    }
    out.push_back(window);
  }
  return out;
}

Json causes_json(const std::vector<diagnosis::Structure>& structure) {
  Json out = Json::array();
  for (const diagnosis::Structure& s : structure) {
    out.push_back({{"sensor", s.sensor}, {"axis", s.axis}, {"against", s.against}, {"unit", s.unit}, {"cause", s.bin_cause},
                   {"mean", s.bin_mean}, {"sigma", s.bin_sigma}});
  }
  return out;
}

}  // namespace

std::string diagnosis_data_json(const Diagnosis& d, const std::vector<Recording>& sessions) {
  const std::vector<Frame>& frames = sessions.front().cameras.front().frames;
  const std::int64_t zero_ns = frames.empty() ? 0 : frames.front().t_ns;
  Json json = {{"windows", windows_json(d, zero_ns)}, {"causes_before", causes_json(d.where)}, {"causes_after", causes_json(d.left)}};
  return json.dump();
}

void write_diagnosis(const std::filesystem::path& folder, const Diagnosis& d, const std::vector<Recording>& sessions) {
  const ReplayResult& last = d.fit_after.kept.empty() ? d.fit_before : d.fit_after;
  if (!last.calibration.cameras.empty()) {
    write_camchain(folder / "camchain-imucam.yaml", last.calibration);
    write_imu_yaml(folder / "imu.yaml", last.calibration, d.noise);
  }
  write_file(folder / "model.yaml", model_yaml(d.model.empty() ? d.fit_before : last));  // what got no name is not in it
  write_file(folder / "segcal_effects.h", effects_header(d));
  write_file(folder / "diagnosis_data.json", diagnosis_data_json(d, sessions));
  write_file(folder / "diagnosis.json", diagnosis_json(d) + "\n");  // last: its presence says the rest is there
}

}  // namespace host
