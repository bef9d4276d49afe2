// segcal diagnose: what is missing in the model?
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <optional>

#include "commands.h"
#include "diagnose/diagnose.h"
#include "diagnose/exposure_offset.h"
#include "files/output_run.h"
#include "formatted.h"
#include "imu_temperature.h"
#include "replay/model_file.h"
#include "replay/replay_clocks.h"
#include "replay/sessions.h"
#include "twin/twin_folder.h"
#include "twin/twin_report.h"

namespace host {
namespace {

struct DiagnoseArguments {
  std::vector<std::string> recordings;
  std::string calibration, model, out, twin;
  int cameras = 1;
  bool json = false, smooth_stamps = false;
  std::optional<double> stamp_exposure;
  DiagnoseOptions diagnose;
};

void show_progress(const std::string& step, double fraction) {
  static std::string last;
  const bool terminal = isatty(STDERR_FILENO) != 0;
  if (!terminal && step == last) return;
  if (terminal && step != last && !last.empty()) std::cerr << "\n";
  last = step;
  std::cerr << (terminal ? "\r" : "") << "diagnose: " << step;
  if (terminal) std::cerr << " " << static_cast<int>(100 * fraction) << " %   ";
  std::cerr << (terminal ? "" : "\n") << std::flush;
}

void print_effects(const Diagnosis& d) {
  if (d.effects.empty()) return;
  std::printf("%-34s %14s %12s %-12s %10s %8s %7s\n", "effect", "value", "sigma", "unit", "statistic", "log10 p",
              "closed");
  for (const DiagnosedEffect& e : d.effects) {
    bool first = true;
    for (const DiagnosedParameter& p : e.parameters) {
      std::printf("%-34s %14.6g %12.2g %-12s", p.name.c_str(), p.value, p.sigma, p.unit.c_str());
      if (first)
        std::printf(" %10.1f %8.1f %s", e.statistic, e.log10_p,
                    std::isnan(e.gap_closed) ? "      -" : formatted("%6.1f %%", 100 * e.gap_closed).c_str());
      std::printf("\n");
      first = false;
    }
    for (const std::string& other : e.or_else)
      std::printf("  or %s; told apart by %s\n", other.c_str(), e.separates.c_str());
  }
}

void print_table(const Diagnosis& d) {
  for (const Fault& f : d.faults)
    std::printf("%s, %s: %zu times, %s\n", f.kind.c_str(), f.sensor.c_str(), f.count, f.words.c_str());
  print_effects(d);
  for (const NotNamed& n : d.rejected) std::printf("not %s: %s\n", n.name.c_str(), n.why.c_str());
  for (const NotNamed& n : d.cannot_tell) std::printf("cannot tell %s: %s\n", n.name.c_str(), n.why.c_str());
  std::size_t shown = 0;
  for (const diagnosis::Structure& s : d.where) {
    if (++shown > 5) break;
    std::printf("%s %s follows %s, correlation %.3f\n", s.sensor.c_str(), s.axis.c_str(), s.against.c_str(),
                s.correlation);
  }
  if (d.tracks.points > 0) {
    std::printf(
        "corner tracks drift: %.2f px of white noise and a walk of %.2f px/sqrt(s) were taken, and not the stated "
        "noise\n",
        d.tracks.white_px, d.tracks.walk_px_per_sqrt_s);
  }
  for (const SensorNoise* n : {&d.raw_noise.gyro, &d.raw_noise.accel})
    if (n->grows) std::printf("%s\n", n->words.c_str());
  std::printf("%s: %s\n", d.judged ? d.verdict.c_str() : "cannot tell", d.sentence.c_str());
}

/// Of stamps and exposures, found or stated; 0: none.
double kappa_of(const DiagnoseArguments& a, const Diagnosis& d) {
  for (const ModelTerm& t : d.model)
    if (t.effect == diagnosis::kExposureOffset) return t.parameter.value;
  return a.stamp_exposure.value_or(0);
}

/// What to do with the answer: the commands that use it.
void print_next(const DiagnoseArguments& a, const Diagnosis& d) {
  if (!d.judged || d.model.empty()) return;
  const double kappa = kappa_of(a, d);
  const bool more = d.model.size() > 1 || d.model.front().effect != diagnosis::kExposureOffset;
  const std::string model = more ? " --model " + (std::filesystem::path(a.out) / "model.yaml").string() : "";
  std::string replay = "segcal replay";
  for (const std::string& r : a.recordings) replay += " " + r;
  if (!a.calibration.empty()) replay += " --calib " + a.calibration;
  if (a.smooth_stamps) replay += " --smooth-stamps";
  if (kappa != 0) replay += formatted(" --stamp-exposure %.3g", kappa);
  if (a.cameras != 1) replay += " --cameras " + std::to_string(a.cameras);
  if (d.tracks.points > 0)
    replay += formatted(" --pixel-sigma %.3g --track-walk %.3g", d.tracks.white_px, d.tracks.walk_px_per_sqrt_s);
  std::printf("\nnext: %s%s --out %s   calibrates with what was found\n", replay.c_str(), model.c_str(),
              (std::filesystem::path(a.out) / "replay").string().c_str());
  std::printf("      segcal simulate --out alike%s%s   a device with the same departure from the model\n",
              model.c_str(), kappa != 0 ? formatted(" --effect exposure_offset=%.3g", kappa).c_str() : "");
  if (a.twin.empty())
    std::printf(
        "      the same command with --twin DIR   how much nearer a simulation with it comes to the measurement\n");
  std::printf("      segcal report %s   draws where the model and the measurements disagreed\n", a.out.c_str());
}

/// A model that follows temperatures which nobody can read says nothing.
void expect_temperature(const EffectChoice& model, const std::vector<Recording>& sessions) {
  if (!model.follows_temperature()) return;
  for (const Recording& session : sessions) {
    const TemperatureJumps& jumps = session.imu.temperature_jumps;
    const std::string expected = session.root.string() + ": expected temperatures for the effects of --model";
    if (jumps.count > 0 && !jumps.bridged) throw InputError(expected + "; " + temperature_words(session.imu));
    if (!session.imu.has_temperature) throw InputError(expected + ", found an IMU log without them");
  }
}

int run(DiagnoseArguments a) {
  expect_output_folder(a.out, "diagnose");
  if (!a.twin.empty()) {
    if (a.recordings.size() > 1)
      throw InputError("--twin: expected one recording, found " + std::to_string(a.recordings.size()) +
                       "; a twin is of one session");
    twin::expect_twin_folder(a.twin, {a.out, a.recordings.front()});
  }
  const std::vector<Recording> sessions = read_sessions(a.recordings, a.cameras, a.smooth_stamps, a.stamp_exposure);
  a.diagnose.stamp_exposure = a.stamp_exposure.value_or(0);
  a.diagnose.core.calibration = find_calibration(a.recordings.front(), a.calibration, a.cameras);
  a.diagnose.core.noise = sessions.front().imu.noise;
  if (!a.model.empty()) {
    EffectChoice model = read_model(a.model);
    expect_temperature(model, sessions);
    // once, not in both
    a.diagnose.core.calibration.cameras.front().timeshift_cam_imu = stated_offset(a.diagnose.core.calibration, model);
    if (model.enabled("time_offset")) model.set("time_offset.t_d", 0);
    model.apply(&a.diagnose.core);
  }
  a.diagnose.progress = show_progress;
  const Diagnosis d = diagnose(sessions, a.diagnose);
  twin::Comparison twin;
  std::vector<std::pair<std::string, std::string>> beside;
  if (!a.twin.empty()) {
    twin = twin::compare_with_twin(sessions.front(), d, a.diagnose);
    beside.emplace_back("twin.json", twin::as_json(twin));
  }
  write_diagnosis(a.out, d, sessions, beside);
  if (twin.twin) twin::write_twin(*twin.twin, a.twin);
  if (isatty(STDERR_FILENO)) std::cerr << "\n";
  if (a.json && !twin.why_not.empty()) std::cerr << "no twin: " << twin.why_not << "\n";
  if (a.json) {
    std::cout << diagnosis_json(d) << std::endl;
  } else {
    print_table(d);
    if (!a.twin.empty()) std::fputs(twin::as_table(twin).c_str(), stdout);
    print_next(a, d);
  }
  return d.judged && d.verdict != "unexplained" ? 0 : 1;
}

}  // namespace

void add_diagnose_command(CLI::App& app, int& exit_code) {
  auto a = std::make_shared<DiagnoseArguments>();
  CLI::App* sub = app.add_subcommand(
      "diagnose", "residuals are large: find the effect that the model lacks, and measure the gap that it closes");
  sub->add_option("recordings", a->recordings,
                  "recordings in ASL layout (REC/mav0/...); several are sessions of one device")
      ->required();
  sub->add_option("--calib", a->calibration,
                  "calibration to start from, Kalibr's camchain-imucam.yaml (default: the recording's own)");
  sub->add_option("--model", a->model, "model.yaml with effects that are already known");
  sub->add_option("--out", a->out,
                  "folder for diagnosis.json, model.yaml, segcal_effects.h and what `segcal report` draws")
      ->required();
  sub->add_option("--profile", a->diagnose.profile, "capacities of the core; host keeps 64 segments, four minutes")
      ->capture_default_str();
  sub->add_option("--cameras", a->cameras, "cameras to use, cam0 first")
      ->capture_default_str()
      ->check(CLI::Range(1, 2));
  sub->add_option("--pixel-sigma", a->diagnose.core.pixel_sigma, "stated noise of a tracked corner per axis, px")
      ->capture_default_str()
      ->check(CLI::PositiveNumber);
  sub->add_flag("--smooth-stamps", a->smooth_stamps,
                "for stamps taken in callbacks: smooth them first, as segcal replay does");
  sub->add_option("--stamp-exposure", a->stamp_exposure,
                  "K times the exposure is added to each image's stamp first, as segcal replay does; what is found "
                  "counts from the recording's own stamps")
      ->type_name("K")
      ->check(CLI::Range(-1.0, 1.0));
  sub->add_flag("--accept-faults", a->diagnose.accept_faults,
                "continue when the samples themselves are faulty (bad_data); the faults are still reported");
  sub->add_option(
         "--twin", a->twin,
         "simulate the recording's twin, the same motion and corners, without effects and with those that were "
         "found; say how much nearer it comes to the measurement (also in twin.json), and leave it in this folder as a "
         "recording. One recording only; takes twice as long again")
      ->type_name("DIR");
  sub->add_flag("--json", a->json, "print diagnosis.json on standard output");
  sub->footer(R"(Example:
  segcal simulate --out late --scenario rich --seconds 60 --seed 1 --effect time_offset=0.003
  segcal diagnose late --out d --twin twin && segcal report d

Verdicts: consistent, nothing is missing; explained, the named effects close the gap; partly_explained, some of it stays
open; unexplained, something is missing that has no name here: `where` says in which sensor and what it follows; bad_data,
the samples themselves are faulty (segcal replay continues with such data, and lists the faults among its suspects).

An effect is named if it is significant after correction for the number of candidates, both halves of the recording
give the same value, and the value from one half removes the excess of the other. Exit code 1: too short or too still to
judge, or unexplained.)");
  sub->callback([a, &exit_code] { exit_code = run(*a); });
}

}  // namespace host
