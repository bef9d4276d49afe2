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

Asked ask(const SimulationOptions& simulation, DiagnoseOptions options, const char* which) {
  Asked out{simulate(simulation), {}};
  options.core.calibration = out.simulated.nominal;
  options.accept_faults = true;  // samples are as they are made: what looks like a fault is for the reader to weigh
  options.dictionary = false;    // words for what has no name: no figure here needs them
  options.stamp_exposure = 0;
  if (options.progress)
    options.progress = [report = options.progress, which](const std::string& step, double fraction) {
      report(std::string("twin ") + which + ", " + step, fraction);
    };
  out.diagnosis = diagnose({out.simulated.recording}, options);
  return out;
}

std::string why_nothing_to_follow(const Diagnosis& found) {
  if (found.verdict == "bad_data") return "the data are at fault (--accept-faults goes on with them)";
  if (!found.judged || !found.lost.empty() || found.fit_before.kept.empty())
    return "there is no fit that a simulation could follow: " + found.sentence;
  return "";
}

double seconds_of(const Recording& session) {
  const std::vector<Frame>& frames = session.cameras.front().frames;
  return 1e-9 * static_cast<double>(frames.back().t_ns - frames.front().t_ns);
}

std::string said(const Diagnosis& d) { return d.verdict + ": " + d.sentence; }

}  // namespace

bool Statistic::differs() const {
  return sigma > 0 && std::abs(measured - plain) > sigmas_apart * std::sqrt(2.0) * sigma;
}

double Statistic::left() const { return std::abs(measured - with_effects) / std::abs(measured - plain); }

double Statistic::left_sigma() const { return std::sqrt(2.0) * sigma / std::abs(measured - plain); }

Comparison compare_with_twin(const Recording& session, const Diagnosis& found, const DiagnoseOptions& options) {
  Comparison out;
  out.why_not = why_nothing_to_follow(found);
  if (!out.why_not.empty()) return out;
  try {
    const SimulationOptions plain = plain_twin(session, found, options),
                            with = with_effects(plain, session, found, options, &out);
    out.seconds = plain.seconds;
    out.recorded_s = seconds_of(session);
    out.statistics = statistics_of(found);
    const Asked a = ask(plain, options, "without effects"), b = ask(with, options, "with effects");
    const std::vector<double> of_plain = same_of(out.statistics, a.simulated.recording, a.diagnosis),
                              of_twin = same_of(out.statistics, b.simulated.recording, b.diagnosis);
    for (std::size_t i = 0; i < out.statistics.size(); ++i) {
      out.statistics[i].plain = of_plain[i];
      out.statistics[i].with_effects = of_twin[i];
    }
    out.said_of_plain = said(a.diagnosis);
    out.said_of_twin = said(b.diagnosis);
    out.twin = b.simulated;
  } catch (const InputError& error) {
    out = Comparison{};
    out.why_not = error.what();
  }
  return out;
}

}  // namespace host::twin
