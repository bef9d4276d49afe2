#include "device_log/device_log.h"
#include "replay/result_files.h"
#include "replay/words.h"

namespace host {
namespace {

using Json = nlohmann::ordered_json;

Json direction_json(const CoreDirection& d, const std::vector<std::string>& names) {
  Json weights = Json::object();
  for (const auto& [name, weight] : main_weights(d, names)) weights[name] = weight;
  return {{"direction", weights}, {"sigma", d.relative_sigma}, {"words", in_words(d, names)}};
}

Json parameters_json(const CoreResult& r) {
  Json out = Json::array();
  for (const CoreParameter& p : r.parameters) {
    out.push_back({{"name", p.name},
                   {"value", p.value},
                   {"sigma", p.sigma},
                   {"unit", p.unit},
                   {"initial", p.initial},
                   {"prior_sigma", p.prior_sigma},
                   {"verdict", p.verdict}});
  }
  return out;
}

Json segment_json(const CoreSegment& s, const std::vector<std::string>& names) {
  Json words = Json::array();
  for (const CoreDirection& d : s.not_excited) words.push_back(in_words(d, names));
  return {{"session", s.session},
          {"start_ns", s.start_ns},
          {"end_ns", s.end_ns},
          {"keyframes", s.keyframes},
          {"landmarks", s.landmarks},
          {"A", s.A},
          {"D", s.D},
          {"E", s.E},
          {"rank", s.rank},
          {"kept", s.kept},
          {"settled", s.settled},
          {"outdated", s.outdated},
          {"gain_nats", s.gain_nats},
          {"not_excited", words}};
}

Json calibrations_json(const ReplayResult& out) {
  Json json = Json::array();
  for (const ReplayCalibration& c : out.calibrations) {
    json.push_back(
        {{"t_ns", c.t_ns}, {"by", c.by_targets ? "targets" : "end"}, {"segments", c.segments}, {"status", c.status}});
  }
  return json;
}

Json text_or_null(const std::string& text) { return text.empty() ? Json() : Json(text); }

Json passes_json(const std::vector<ReplayPass>& passes) {
  Json json = Json::array();
  for (const ReplayPass& p : passes) {
    json.push_back({{"status", p.status},
                    {"segments", p.segments},
                    {"segments_scored", p.segments_scored},
                    {"frames_used", p.frames_used},
                    {"filter_restarts", p.filter_restarts},
                    {"chi2_per_dof", p.chi2_per_dof},
                    {"step_sigmas", p.step_sigmas},
                    {"moved", text_or_null(p.moved)},
                    {"settled", p.settled()}});
  }
  return json;
}

/// Which device, log, program and configuration a result comes from.
void add_origin(const Provenance& from, Json* json) {
  (*json)["device_id"] = text_or_null(from.device_id);
  (*json)["device_model"] = text_or_null(from.device_model);
  (*json)["log_sha256"] = from.logs.empty() ? Json() : Json(sha256_of_logs(from.logs));
  (*json)["library_version"] = SEGCAL_PROGRAM_VERSION;
}

Json logs_json(const std::vector<LogIdentity>& logs) {
  Json json = Json::array();
  for (const LogIdentity& log : logs) json.push_back({{"name", log.name}, {"sha256", log.sha256}});
  return json;
}

Json health_json(const Health& h) {
  Json suspects = Json::array();
  for (const Suspect& s : h.suspects) {
    suspects.push_back({{"name", s.name},
                        {"statistic", s.statistic},
                        {"log10_p", s.log10_p},
                        {"bias_sigmas", s.bias_sigmas},
                        {"moves", s.moves},
                        {"in_sigmas", s.in_sigmas},
                        {"certain", s.certain},
                        {"words", s.words}});
  }
  Json notes = Json::array();
  for (const Note& n : h.notes) notes.push_back({{"name", n.name}, {"factor", n.factor}, {"words", n.words}});
  return {{"frames", h.frames},
          {"frames_used", h.frames_used},
          {"frames_offered", h.frames_offered},
          {"filter_restarts", h.filter_restarts},
          {"segment_scatter", h.segment_scatter},
          {"step_chi2", h.step_chi2},
          {"step_dof", h.step_dof},
          {"suspects", suspects},
          {"notes", notes}};
}

Json change_json(const CoreChange& c, const std::vector<std::string>& names, const CoreResult& r) {
  Json steps = Json::array();
  for (std::size_t i = 0; i < c.step.size() && i < names.size() && !c.open; ++i) {
    steps.push_back({{"name", names[i]}, {"step", c.step[i]}, {"sigma", c.sigma[i]}});
  }
  return {{"open", c.open},
          {"between_sessions", {c.before_session, c.after_session}},
          {"t_ns", c.t_ns},
          {"words", change_words(c, r)},
          {"steps", steps}};
}

Json epoch_json(const CoreEpoch& e) {
  return {{"segments", e.segments},
          {"first_session", e.first_session},
          {"last_session", e.last_session},
          {"value", e.value},
          {"sigma", e.sigma}};
}

Json session_json(const CoreSession& s) {
  return {{"session", s.first_session},  {"segments", s.segments}, {"temperature_degC", s.temperature_degC},
          {"changes_before", s.changes}, {"value", s.value},       {"sigma", s.sigma}};
}

Json course_json(const CoreResult& r, const std::vector<std::string>& names) {
  const CoreCourse& c = r.course;
  Json ln_odds = Json::object(), rates = Json::array();
  for (std::size_t f = 0; f < course_names.size() && !c.courses.empty(); ++f) {
    if (c.ln_odds[f] <= 0) ln_odds[course_names[f]] = c.ln_odds[f];
  }
  for (std::size_t i = 0; i < c.rate.size() && i < names.size() && !c.rate_of.empty(); ++i) {
    if (c.sigma[i] > 0) rates.push_back({{"name", names[i]}, {"rate", c.rate[i]}, {"sigma", c.sigma[i]}});
  }
  return {{"courses", c.courses},
          {"sessions", c.sessions},
          {"words", course_words(r)},
          {"ln_odds", ln_odds},
          {"rate_of", c.rate_of},
          {"step_before_session", c.rate_of == "steps" ? Json(c.step_session) : Json()},
          {"rates", rates}};
}

}  // namespace

Json result_json(const ReplayResult& out, const Provenance& from) {
  const CoreResult& r = out.result;
  const std::vector<std::string> names = parameter_names(r, out.calibration);
  Json json;
  json["format"] = 2;
  json["status"] = r.status;
  if (!out.cause.empty()) json["cause"] = out.cause;
  add_origin(from, &json);
  json["logs"] = logs_json(from.logs);
  if (from.earlier_logs) json["earlier_logs"] = logs_json(*from.earlier_logs);
  if (from.begins_with_state) json["begins_with_state"] = true;
  json["configuration"] = from.configuration;
  json["temperature_degC"] = from.temperature_degC ? Json(*from.temperature_degC) : Json();
  json["health"] = health_json(out.health);
  json["parameters"] = parameters_json(r);
  json["mean"] = r.mean;
  json["covariance"] = r.covariance;
  json["unobservable"] = Json::array();
  for (const CoreDirection& d : r.unobservable) json["unobservable"].push_back(direction_json(d, names));
  json["segments"] = Json::array();
  for (const CoreSegment& s : out.segments) json["segments"].push_back(segment_json(s, names));
  json["calibrations"] = calibrations_json(out);
  if (out.passes.size() > 1) json["passes"] = passes_json(out.passes);
  json["epochs"] = Json::array();
  for (const CoreEpoch& e : r.epochs) json["epochs"].push_back(epoch_json(e));
  json["changes"] = Json::array();
  for (const CoreChange& c : out.result.changes) json["changes"].push_back(change_json(c, names, r));
  json["history"] = Json::array();
  for (const CoreSession& s : r.history) json["history"].push_back(session_json(s));
  json["course"] = course_json(r, names);
  json["fit"] = {{"chi2", r.chi2},
                 {"dof", r.dof},
                 {"iterations", r.iterations},
                 {"converged", r.converged},
                 {"reprojection_rms_px", r.reprojection_rms_px},
                 {"reprojection_median_px", r.reprojection_median_px},
                 {"noise_scale", r.noise_scale},
                 {"partitions", r.partitions},
                 {"image_points", r.image_points}};
  json["noise"] = {{"track_white_px", out.track_noise.white_px},
                   {"track_walk_px_per_sqrt_s", out.track_noise.walk_px_per_sqrt_s},
                   {"track_points", out.track_noise.points},
                   {"stated_white_px", out.model.pixel_sigma},
                   {"stated_walk_px_per_sqrt_s", out.model.track_walk},
                   {"weighed_by_tracks", out.weighed_by_tracks}};
  json["timing"] = {{"vio_ms_median", out.timing.vio_ms_median},
                    {"vio_ms_p95", out.timing.vio_ms_p95},
                    {"score_ms_median", out.timing.score_ms_median},
                    {"calibrate_ms", out.timing.calibrate_ms}};
  json["memory"] = {{"state_bytes", out.memory.state_bytes},
                    {"segment_bytes", out.memory.segment_bytes},
                    {"workspace_bytes", out.memory.workspace_bytes}};
  json["result_hash"] = hash_text(out.result_hash);
  json["faults"] = Json::object();
  for (const auto& [name, count] : out.counters) json["faults"][name] = count;
  return json;
}

std::string calibration_lines(const ReplayResult& out, const Provenance& from) {
  std::string text;
  const Json calibrations = calibrations_json(out);
  for (std::size_t i = 0; i < calibrations.size(); ++i) {
    Json line = {{"format", 1}};
    add_origin(from, &line);
    line.update(calibrations[i]);
    line["parameters"] = Json::array();
    for (const CoreParameter& p : out.calibrations[i].parameters) {
      line["parameters"].push_back(
          {{"name", p.name}, {"value", p.value}, {"sigma", p.sigma}, {"unit", p.unit}, {"verdict", p.verdict}});
    }
    text += line.dump() + "\n";
  }
  return text;
}

}  // namespace host
