// The paper normalises a segment's covariance by "the expected standard deviation that has been obtained empirically
// from a set of segments" (Sec. V-B), per sensor set-up. Here: each parameter's median sigma over all segments of the
// recordings, of one segment and the prior.
#include "experiments/datasets.h"
#include "experiments/registry.h"
#include "experiments/statistics.h"
#include "replay/replay.h"

namespace host::experiments {
namespace {

Recording recorded(const Json& parameters, Calibration* calibration) {
  const std::string root = parameters.at("recording"), start = parameters.at("calibration");
  Recording recording = read_recording(root, 1);
  if (recording.cameras[0].frames.empty()) {
    throw InputError(root + "/mav0/cam0/tracks.csv: missing; run `segcal track " + root +
                     "` first to make it from the images");
  }
  *calibration = find_calibration(root, start, 1);
  return recording;
}

Recording simulated(const Json& parameters, Calibration* calibration) {
  const SimulationResult session = simulate_session(dataset_named(parameters.at("dataset")), parameters.at("seed"),
                                                    parameters.at("session"), parameters.at("session_s"));
  *calibration = session.nominal;
  return session.recording;
}

}  // namespace

std::vector<Cell> sigma_ref_cells(const StudyOptions& options) {
  std::vector<Cell> cells;
  for (std::size_t i = 0; i < options.recordings.size(); ++i) {
    cells.push_back({"recording" + std::to_string(i),
                     {{"recording", options.recordings[i].string()}, {"calibration", options.calibration.string()}}});
  }
  if (!options.recordings.empty()) return cells;
  for (const Dataset& d : datasets()) {
    for (int session = 0; session < (options.quick ? 1 : d.sessions); ++session) {
      cells.push_back(
          {std::string(d.name) + "_session" + std::to_string(session),
           {{"dataset", d.name}, {"session", session}, {"session_s", d.session_s}, {"seed", options.seed}}});
    }
  }
  return cells;
}

Json sigma_ref_run(const Json& parameters) {
  ReplayOptions options;
  const Recording recording = parameters.contains("recording") ? recorded(parameters, &options.core.calibration)
                                                               : simulated(parameters, &options.core.calibration);
  options.core.noise = recording.imu.noise;
  const ReplayResult r = replay({recording}, options);
  Json names = Json::array(), segments = Json::array();
  for (const CoreParameter& p : r.result.parameters)
    names.push_back({{"name", p.name}, {"unit", p.unit}, {"prior_sigma", p.prior_sigma}});
  for (const CoreSegment& s : r.segments) segments.push_back(s.sigma);
  return {{"parameters", names}, {"segments", segments}};
}

Findings sigma_ref_gather(const std::vector<CellResult>& cells) {
  Findings out;
  Table table{"Sigma of one segment",
              "Quartiles over all segments. sigma_ref is the median; a parameter that most segments do not tell has "
              "its prior's sigma.",
              {{"parameter", ""},
               {"unit", ""},
               {"sigma_ref", "unit"},
               {"lower quartile", "unit"},
               {"upper quartile", "unit"},
               {"prior sigma", "unit"},
               {"sigma_ref against the prior", "-"},
               {"segments", "-"}},
              {}};
  Figure figure{"Sigma of one segment against the prior's", "bars", "parameter", "sigma / prior sigma [-]", true, {}};
  Series bars{"median", {}, {}};
  out.values["sigma_ref"] = Json::object();
  const Json* parameters = nullptr;
  for (const CellResult& c : cells) {
    if (!c.result.at("parameters").empty()) parameters = &c.result.at("parameters");
  }
  if (!parameters) throw InputError("sigma_ref: expected a recording with at least one segment that tells something");
  for (std::size_t i = 0; i < parameters->size(); ++i) {
    std::vector<double> sigma;
    for (const CellResult& c : cells) {
      for (const Json& segment : c.result.at("segments")) {
        if (segment.size() != parameters->size())
          throw InputError("sigma_ref: expected recordings of one kind of device");
        sigma.push_back(segment.at(i));
      }
    }
    const Json& p = parameters->at(i);
    const double prior = p.at("prior_sigma");
    table.rows.push_back({p.at("name"), p.at("unit"), median(sigma), quantile(sigma, 0.25), quantile(sigma, 0.75),
                          prior, median(sigma) / prior, sigma.size()});
    bars.x.push_back(p.at("name"));
    bars.y.push_back(median(sigma) / prior);
    out.values["sigma_ref"][p.at("name").get<std::string>()] = median(sigma);
  }
  figure.series = {bars};
  out.tables = {table};
  out.figures = {figure};
  return out;
}

}  // namespace host::experiments
