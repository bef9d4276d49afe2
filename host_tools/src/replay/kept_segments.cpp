#include "replay/kept_segments.h"

#include <nlohmann/json.hpp>

#include "csv.h"
#include "json_numbers.h"
#include "replay/words.h"

namespace host {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kFormat = 1;

template <int Rows, int Columns>
Json array_of(const Eigen::Matrix<double, Rows, Columns>& m) {
  Json out = Json::array();
  for (int i = 0; i < Rows; ++i) {
    for (int j = 0; j < Columns; ++j) out.push_back(m(i, j));
  }
  return out;
}

template <int Rows, int Columns>
void read_array(const Json& json, Eigen::Matrix<double, Rows, Columns>* m) {
  if (json.size() != Rows * Columns)
    throw InputError("expected a list of " + std::to_string(Rows * Columns) + " numbers");
  for (int i = 0; i < Rows; ++i) {
    for (int j = 0; j < Columns; ++j) (*m)(i, j) = json.at(static_cast<std::size_t>(i * Columns + j)).get<double>();
  }
}

/// The names of the model's figures in the file, and where they are.
const std::vector<std::pair<const char*, double CoreModel::*>>& model_fields() {
  static const std::vector<std::pair<const char*, double CoreModel::*>> fields = {
      {"gyro_noise_density", &CoreModel::gyro_noise_density},
      {"gyro_random_walk", &CoreModel::gyro_random_walk},
      {"accel_noise_density", &CoreModel::accel_noise_density},
      {"accel_random_walk", &CoreModel::accel_random_walk},
      {"gravity", &CoreModel::gravity},
      {"pixel_sigma", &CoreModel::pixel_sigma},
      {"huber", &CoreModel::huber},
      {"bias_a_sigma", &CoreModel::bias_a_sigma},
      {"bias_g_sigma", &CoreModel::bias_g_sigma},
      {"velocity_sigma", &CoreModel::velocity_sigma},
      {"inverse_depth_sigma", &CoreModel::inverse_depth_sigma},
      {"turned_inverse_depth_sigma", &CoreModel::turned_inverse_depth_sigma},
      {"track_walk", &CoreModel::track_walk}};
  return fields;
}

Json calibration_json(const Calibration& c) {
  Json cameras = Json::array();
  for (const CameraCalibration& camera : c.cameras) {
    cameras.push_back({{"model", distortion_name(camera.model)},
                       {"width", camera.width},
                       {"height", camera.height},
                       {"intrinsics", array_of(camera.intrinsics)},
                       {"distortion", array_of(camera.distortion)},
                       {"R_CI", array_of(camera.R_CI)},
                       {"p_CI", array_of(camera.p_CI)},
                       {"readout", camera.reads_columns ? "columns" : "rows"},
                       {"timeshift_cam_imu", camera.timeshift_cam_imu}});
  }
  return {
      {"cameras", cameras}, {"T_g", array_of(c.imu.T_g)}, {"T_a", array_of(c.imu.T_a)}, {"R_AI", array_of(c.imu.R_AI)}};
}

Calibration read_calibration_json(const Json& json) {
  Calibration out;
  for (const Json& c : json.at("cameras")) {
    CameraCalibration camera;
    camera.model = distortion_from_name(c.at("model").get<std::string>());
    camera.width = whole_number<int>(c.at("width"));
    camera.height = whole_number<int>(c.at("height"));
    camera.reads_columns = reads_columns(c.value("readout", "rows"));
    read_array(c.at("intrinsics"), &camera.intrinsics);
    read_array(c.at("distortion"), &camera.distortion);
    read_array(c.at("R_CI"), &camera.R_CI);
    read_array(c.at("p_CI"), &camera.p_CI);
    camera.timeshift_cam_imu = c.at("timeshift_cam_imu").get<double>();
    out.cameras.push_back(camera);
  }
  read_array(json.at("T_g"), &out.imu.T_g);
  read_array(json.at("T_a"), &out.imu.T_a);
  read_array(json.at("R_AI"), &out.imu.R_AI);
  return out;
}

/// Long lists are arrays of numbers, not objects: a segment has a thousand samples and as many points.
Json segment_json(const CoreKept& k) {
  Json json = {{"session", k.segment.session}, {"serial", k.segment.serial},  {"join", k.join}, {"gap_s", k.gap_s},
               {"lead_ns", k.lead_ns},         {"turned_only", k.turned_only}};
  for (const char* name : {"keyframes", "landmarks", "points", "samples"}) json[name] = Json::array();
  for (const CoreState& x : k.keyframes) {
    json["keyframes"].push_back({{"t_ns", x.t_ns},
                                 {"q_GI_wxyz", array_of(x.q_GI_wxyz)},
                                 {"p_GI", array_of(x.p_GI)},
                                 {"v_GI", array_of(x.v_GI)},
                                 {"b_a", array_of(x.b_a)},
                                 {"b_g", array_of(x.b_g)}});
  }
  for (const CoreLandmark& l : k.landmarks) {
    json["landmarks"].push_back({{"track_id", l.track_id},
                                 {"tie", l.tie},
                                 {"anchor", array_of(l.anchor)},
                                 {"direction", array_of(l.direction)},
                                 {"inverse_distance", l.inverse_distance}});
  }
  for (const CorePoint& z : k.measured)
    json["points"].push_back({z.landmark, z.keyframe, z.camera, z.u, z.v, z.rejected ? 1 : 0});
  for (const ImuSample& s : k.samples) {
    json["samples"].push_back({s.t_ns, s.gyro[0], s.gyro[1], s.gyro[2], s.accel[0], s.accel[1], s.accel[2]});
  }
  return json;
}

CoreState read_keyframe(const Json& json) {
  CoreState x;
  x.t_ns = whole_number<std::int64_t>(json.at("t_ns"));
  read_array(json.at("q_GI_wxyz"), &x.q_GI_wxyz);
  read_array(json.at("p_GI"), &x.p_GI);
  read_array(json.at("v_GI"), &x.v_GI);
  read_array(json.at("b_a"), &x.b_a);
  read_array(json.at("b_g"), &x.b_g);
  return x;
}

CoreLandmark read_landmark(const Json& json) {
  CoreLandmark l;
  l.track_id = whole_number<std::uint32_t>(json.at("track_id"));
  l.tie = whole_number<int>(json.at("tie"));
  read_array(json.at("anchor"), &l.anchor);
  read_array(json.at("direction"), &l.direction);
  l.inverse_distance = json.at("inverse_distance").get<double>();
  return l;
}

CorePoint read_point(const Json& json, const CoreKept& k, std::size_t n_cameras) {
  const CorePoint z{whole_number<int>(json.at(0)), whole_number<int>(json.at(1)), whole_number<int>(json.at(2)),
                    json.at(3).get<double>(),      json.at(4).get<double>(),      whole_number<int>(json.at(5)) != 0};
  const auto below = [](int i, std::size_t n) { return i >= 0 && static_cast<std::size_t>(i) < n; };
  if (!below(z.landmark, k.landmarks.size()) || !below(z.keyframe, k.keyframes.size()) || !below(z.camera, n_cameras)) {
    throw InputError("a point of a landmark, keyframe or camera that is not there");
  }
  return z;
}

CoreKept read_segment(const Json& json, std::size_t n_cameras) {
  CoreKept k;
  k.segment.session = whole_number<std::uint32_t>(json.at("session"));
  k.segment.serial = whole_number<std::uint32_t>(json.at("serial"));
  k.join = json.at("join").get<std::string>();
  k.gap_s = json.at("gap_s").get<double>();
  k.lead_ns = whole_number<std::int64_t>(json.at("lead_ns"));
  k.turned_only = json.at("turned_only").get<bool>();
  if (k.join != "none" && k.join != "imu" && k.join != "bias") throw InputError("join: expected none, imu or bias");
  for (const Json& x : json.at("keyframes")) k.keyframes.push_back(read_keyframe(x));
  for (const Json& l : json.at("landmarks")) k.landmarks.push_back(read_landmark(l));
  for (const Json& z : json.at("points")) k.measured.push_back(read_point(z, k, n_cameras));
  for (const Json& s : json.at("samples")) {
    ImuSample sample;
    sample.t_ns = whole_number<std::int64_t>(s.at(0));
    for (std::size_t i = 0; i < 3; ++i) {
      sample.gyro[i] = s.at(1 + i).get<double>();
      sample.accel[i] = s.at(4 + i).get<double>();
    }
    k.samples.push_back(sample);
  }
  if (k.keyframes.empty() || k.samples.size() < 2) throw InputError("a segment without keyframes or IMU samples");
  return k;
}

KeptSegments read(const Json& json) {
  if (whole_number<int>(json.at("format")) != kFormat) throw InputError("format: expected " + std::to_string(kFormat));
  KeptSegments out;
  Json model = json.at("model");
  if (!model.contains("track_walk")) model["track_walk"] = 0.0;  // of a version without
  for (const auto& [name, field] : model_fields()) out.model.*field = model.at(name).get<double>();
  out.start = read_calibration_json(json.at("prior").at("mean"));
  out.prior_sigma = json.at("prior").at("sigma").get<std::vector<double>>();
  out.noise.rate_hz = json.at("imu_rate_hz").get<double>();
  out.noise.gyro_noise_density = out.model.gyro_noise_density;
  out.noise.gyro_random_walk = out.model.gyro_random_walk;
  out.noise.accel_noise_density = out.model.accel_noise_density;
  out.noise.accel_random_walk = out.model.accel_random_walk;
  if (out.prior_sigma.size() != parameter_names(out.start).size())
    throw InputError("prior.sigma: expected one per parameter");
  out.effects = json.value("effects", std::vector<std::string>());
  out.scatter = json.value("segment_scatter", 1.0);
  out.condensed = json.value("condensed", 0);
  for (const Json& s : json.at("segments")) out.segments.push_back(read_segment(s, out.start.cameras.size()));
  if (!out.segments.empty() && out.segments.front().join != "none") throw InputError("the first segment hangs on none");
  return out;
}

}  // namespace

std::string kept_segments_json(const KeptSegments& kept) {
  Json json;
  json["format"] = kFormat;
  for (const auto& [name, field] : model_fields()) json["model"][name] = kept.model.*field;
  json["imu_rate_hz"] = kept.noise.rate_hz;
  json["prior"] = {
      {"mean", calibration_json(kept.start)}, {"names", parameter_names(kept.start)}, {"sigma", kept.prior_sigma}};
  json["effects"] = kept.effects;
  json["segment_scatter"] = kept.scatter;
  json["condensed"] = kept.condensed;
  json["segments"] = Json::array();
  for (const CoreKept& k : kept.segments) json["segments"].push_back(segment_json(k));
  return json.dump() + "\n";
}

KeptSegments read_kept_segments(const std::filesystem::path& dir) {
  const std::filesystem::path file = dir / "kept_segments.json";
  if (!std::filesystem::exists(file))
    throw InputError(file.string() + ": missing; `segcal replay REC --out " + dir.string() + "` writes it");
  const std::string text = read_file(file);
  try {
    return read(Json::parse(text));
  } catch (const std::exception& error) {
    throw InputError(file.string() + ": expected what `segcal replay` writes: " + error.what());
  }
}

}  // namespace host
