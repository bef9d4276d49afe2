// diagnosis.json, format 2 (docs/formats.md).
#include <nlohmann/json.hpp>

#include "diagnose/diagnose.h"

namespace host {
namespace {

using Json = nlohmann::ordered_json;

Json effect_json(const DiagnosedEffect& e) {
  Json parameters = Json::array();
  for (const DiagnosedParameter& p : e.parameters) {
    parameters.push_back({{"name", p.name}, {"value", p.value}, {"sigma", p.sigma}, {"unit", p.unit}});
  }
  Json out = {{"name", e.name},       {"parameters", parameters},   {"statistic", e.statistic}, {"dof", e.dof},
              {"log10_p", e.log10_p}, {"gap_closed", e.gap_closed}, {"words", e.words}};
  if (!e.or_else.empty()) {
    out["or"] = e.or_else;
    out["separated_by"] = e.separates;
  }
  return out;
}

Json shares_json(const SensorShares& s) {
  return {{"total", s.total}, {"camera", s.camera}, {"gyro", s.gyro}, {"accel", s.accel}};
}

Json sensors_json(const SensorShares& s) { return {{"camera", s.camera}, {"gyro", s.gyro}, {"accel", s.accel}}; }

Json list_json(const std::vector<NotNamed>& list) {
  Json out = Json::array();
  for (const NotNamed& n : list) out.push_back({{"name", n.name}, {"why", n.why}});
  return out;
}

Json where_json(const Diagnosis& d) {
  Json out = Json::array();
  for (std::size_t i = 0; i < d.where.size(); ++i) {
    const diagnosis::Structure& s = d.where[i];
    out.push_back({{"sensor", s.sensor},
                   {"axis", s.axis},
                   {"against", s.against},
                   {"correlation", s.correlation},
                   {"log10_p", s.log10_p}});
    if (i < d.where_after.size()) out.back()["correlation_after"] = d.where_after[i];
  }
  return out;
}

Json faults_json(const std::vector<Fault>& faults) {
  Json out = Json::array();
  for (const Fault& f : faults) {
    out.push_back({{"kind", f.kind},
                   {"sensor", f.sensor},
                   {"first_ns", f.first_ns},
                   {"last_ns", f.last_ns},
                   {"count", f.count},
                   {"value", f.value},
                   {"limit", f.limit},
                   {"unit", f.unit},
                   {"words", f.words}});
  }
  return out;
}

Json scores_json(const std::vector<CandidateScore>& scores) {
  Json out = Json::array();
  for (const CandidateScore& s : scores) {
    out.push_back({{"name", s.name}, {"statistic", s.statistic}, {"dof", s.dof}, {"log10_p", s.log10_p}});
  }
  return out;
}

Json noise_json(const Diagnosis& d) {
  const auto sensor = [](const SensorNoise& n) {
    static const char* const kVerdict[] = {"as_stated", "above", "below", "cannot_tell"};
    return Json{{"factor", n.factor},
                {"sigma", n.sigma},
                {"verdict", kVerdict[static_cast<int>(n.verdict)]},
                {"lively_factor", n.lively_factor},
                {"grows_with_motion", n.grows}};
  };
  Json tracks;
  if (d.tracks.points > 0)
    tracks = {{"white_px", d.tracks.white_px}, {"walk_px_per_sqrt_s", d.tracks.walk_px_per_sqrt_s}};
  return {{"pixel", {{"factor", d.pixels.factor}, {"sigma", d.pixels.sigma}}},
          {"tracks", tracks},
          {"gyro", sensor(d.raw_noise.gyro)},
          {"accel", sensor(d.raw_noise.accel)}};
}

}  // namespace

std::string diagnosis_json(const Diagnosis& d) {
  Json json;
  json["format"] = 2;
  json["verdict"] = d.verdict;
  json["judged"] = d.judged;
  json["sentence"] = d.sentence;
  json["cut_short"] = d.cut_short;
  json["effects"] = Json::array();
  for (const DiagnosedEffect& e : d.effects) json["effects"].push_back(effect_json(e));
  json["gap"] = {{"before", shares_json(d.before)},
                 {"after", shares_json(d.after)},
                 {"noise_floor", shares_json(d.noise_floor)},
                 {"after_sigma", d.after_sigma},
                 {"sigma", sensors_json(d.gap_sigma)},
                 {"dof", shares_json(d.gap_dof)},
                 {"closed", d.gap_closed}};
  json["where"] = where_json(d);
  json["rejected"] = list_json(d.rejected);
  json["cannot_tell"] = list_json(d.cannot_tell);
  json["scores"] = scores_json(d.scores);
  json["noise"] = noise_json(d);
  json["faults"] = faults_json(d.faults);
  json["faults_accepted"] = d.faults_accepted;
  json["model"] = d.model.empty() ? "" : "model.yaml";
  json["seconds"] = d.seconds;
  return json.dump(1);
}

}  // namespace host
