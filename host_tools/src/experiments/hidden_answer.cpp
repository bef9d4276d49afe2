#include "experiments/hidden_answer.h"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <set>

#include "diagnose/diagnose.h"

namespace host::experiments {
namespace {

constexpr const char* unlisted = "unlisted";

bool is_fault(const std::string& name) {
  return name == "saturation" || name == "dropped_samples" || name == "stamp_jitter";
}

/// "gyro_noise.factor" is its own full name; "t_d" of time_offset is "time_offset.t_d".
std::string full_name(const std::string& effect, const std::string& parameter) {
  const bool complete = parameter.rfind(effect + ".", 0) == 0 || parameter.find("_noise.") != std::string::npos;
  return complete ? parameter : effect + "." + parameter;
}

/// Are both the same when for each pair the one that is there is taken?
bool right_but_for_pairs(const std::set<std::string>& there, std::set<std::string> said, const Json& pairs) {
  for (const Json& pair : pairs) {
    const std::string named = pair[0], other = pair[1];
    if (there.count(named) > 0 || there.count(other) == 0 || said.erase(named) == 0) continue;
    said.insert(other);
  }
  return !pairs.empty() && there == said;
}

}  // namespace

Json diagnosed(const Recording& session, const Calibration& start) {
  DiagnoseOptions options;
  options.core.calibration = start;
  options.core.noise = session.imu.noise;
  const std::clock_t start_clock = std::clock();  // other work on the machine is not this one's time
  const Diagnosis d = diagnose({session}, options);
  const double seconds = static_cast<double>(std::clock() - start_clock) / CLOCKS_PER_SEC;
  Json out = {{"verdict", d.verdict},
              {"judged", d.judged},
              {"named", Json::array()},
              {"values", Json::object()},
              {"pairs", Json::array()},
              {"gap_closed", d.gap_closed},
              {"excess_before", d.before.total},
              {"excess_after", d.after.total},
              {"cannot_tell", d.cannot_tell.size()},
              {"faults", Json::array()},
              {"statistics", Json::object()},
              {"sentence", d.sentence},
              {"seconds", seconds}};
  for (const DiagnosedEffect& e : d.effects) {
    out["named"].push_back(e.name);
    for (const DiagnosedParameter& p : e.parameters) out["values"][full_name(e.name, p.name)] = {p.value, p.sigma};
    for (const std::string& other : e.or_else) out["pairs"].push_back({e.name, other});
  }
  for (const Fault& f : d.faults) out["faults"].push_back(f.kind);
  for (const CandidateScore& s : d.scores) out["statistics"][s.name] = s.statistic;
  return out;
}

Json hidden_truth(const std::vector<sim::EffectTruth>& effects) {
  Json names = Json::array(), values = Json::object();
  for (const sim::EffectTruth& e : effects) {
    names.push_back(e.name);
    for (const auto& p : e.parameters) values[full_name(e.name, p.name)] = p.value;
  }
  return {{"names", names}, {"values", values}};
}

Judged judged(const CellResult& cell) {
  const Json &answer = cell.result.at("answer"), &truth = cell.result.at("truth");
  Judged out;
  out.verdict = answer.at("verdict");
  out.judged = answer.at("judged");
  out.gap_closed = answer.at("gap_closed").is_null() ? std::nan("") : answer.at("gap_closed").get<double>();
  out.seconds = answer.at("seconds");
  out.cannot_tell = !out.judged || answer.at("cannot_tell").get<int>() > 0;
  std::set<std::string> there, said;
  for (const Json& n : truth.at("names")) there.insert(n.get<std::string>());
  for (const Json& n : answer.at("named")) said.insert(n.get<std::string>());
  if (out.verdict == "bad_data")
    for (const Json& kind : answer.at("faults")) said.insert(kind.get<std::string>());
  out.unlisted = said.count(unlisted) > 0;
  out.truth.assign(there.begin(), there.end());
  out.named.assign(said.begin(), said.end());
  out.exact = there == said && answer.at("pairs").empty();
  out.in_pair = !out.exact && right_but_for_pairs(there, said, answer.at("pairs"));
  for (const std::string& name : said)
    out.false_name = out.false_name || (name != unlisted && there.count(name) == 0 && !out.in_pair);
  for (const auto& [name, value] : truth.at("values").items()) {
    const bool given = answer.at("values").contains(name) && answer.at("values")[name][1].is_number();
    if (!given || is_fault(name.substr(0, name.find('.')))) continue;
    const double sigma = answer.at("values")[name][1];
    const double off = std::abs(answer.at("values")[name][0].get<double>() - value.get<double>());
    if (sigma > 0) out.worst_sigmas = std::max(out.worst_sigmas, off / sigma);
  }
  out.in_three_sigma = out.worst_sigmas <= 3;
  out.statistic = std::nan("");
  for (const std::string& name : there)
    if (answer.at("statistics").contains(name))
      out.statistic = std::fmin(out.statistic, answer.at("statistics")[name].get<double>());
  out.visible = !(out.statistic < kVisibleStatistic);
  return out;
}

}  // namespace host::experiments
