#include "twin/twin.h"

#include <cmath>

#include "twin/make.h"
#include "twin/statistics.h"

namespace host::twin {
namespace {

constexpr double sigmas_apart = 3;  // of chance, from which on a simulation is another one than the measurement

/// A simulation, asked as the recording was.
struct Asked {
  SimulationResult simulated;
  Diagnosis diagnosis;
};

Asked ask(const SimulationOptions& simulation, DiagnoseOptions options) {
  Asked out{simulate(simulation), {}};
  options.core.calibration = out.simulated.nominal;
  options.accept_faults = true;  // samples are as they are made: what looks like a fault is for the reader to weigh
  options.dictionary = false;  // words for what has no name: no figure here needs them
  options.stamp_exposure = 0;
  out.diagnosis = diagnose({out.simulated.recording}, options);
  return out;
}

std::string said(const Diagnosis& d) { return d.verdict + ": " + d.sentence; }

}  // namespace

bool Statistic::differs() const { return std::abs(measured - plain) > sigmas_apart * std::sqrt(2.0) * sigma; }

double Statistic::left() const { return std::abs(measured - with_effects) / std::abs(measured - plain); }

double Statistic::left_sigma() const { return std::sqrt(2.0) * sigma / std::abs(measured - plain); }

Comparison compare_with_twin(const Recording& session, const Diagnosis& found, const DiagnoseOptions& options,
                             const std::filesystem::path& folder) {
  Comparison out;
  if (!found.judged || found.fit_before.kept.empty() || found.verdict == "bad_data") {
    out.why_not = "nothing was fitted that a simulation could follow";
    return out;
  }
  try {
    const SimulationOptions plain = plain_twin(session, found, options),
                            with = with_effects(plain, session, found, options, &out);
    out.seconds = plain.seconds;
    out.statistics = statistics_of(found);
    const Asked a = ask(plain, options), b = ask(with, options);
    const std::vector<double> of_plain = same_of(out.statistics, a.simulated.recording, a.diagnosis),
                              of_twin = same_of(out.statistics, b.simulated.recording, b.diagnosis);
    for (std::size_t i = 0; i < out.statistics.size(); ++i) {
      out.statistics[i].plain = of_plain[i];
      out.statistics[i].with_effects = of_twin[i];
    }
    out.said_of_plain = said(a.diagnosis);
    out.said_of_twin = said(b.diagnosis);
    if (!folder.empty()) write_simulation(b.simulated, folder);
  } catch (const InputError& error) {
    out.statistics.clear();
    out.why_not = error.what();
  }
  return out;
}

}  // namespace host::twin
