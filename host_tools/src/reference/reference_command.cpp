// segcal reference: the same question answered by another solver.
#include <cstdio>
#include <iostream>

#include "commands.h"
#include "files/output_run.h"
#include "reference/reference.h"
#include "replay/sessions.h"

namespace host {
namespace {

constexpr const char* reference_explanation =
    "Solves a calibration with Ceres in double precision: an independent answer to compare the core's with. Its\n"
    "residuals are written apart from the core, with automatic derivatives.\n"
    "  --segments-from DIR   exactly the segments that `segcal replay --out DIR` kept (DIR/kept_segments.json): the "
    "same\n"
    "                        keyframes, image points, IMU samples and weights, so that both must agree\n"
    "  without it            full batch: all keyframes and all tracks of the whole recordings in one problem, what a\n"
    "                        calibration from selected segments is measured against";

constexpr const char* examples = R"(Examples:
  segcal replay rec --out out && segcal reference rec --segments-from out --out ref
      out/result.json and ref/result.json answer the same question
  segcal reference monday tuesday --out batch
      two sessions of one device share the calibration

DIR2 receives result.json (fields as replay's), camchain-imucam.yaml, imu.yaml and trajectory.tum. Exit code 1: the result
is not `calibrated`; 2: bad usage or input.)";

struct ReferenceArguments {
  std::vector<std::string> recordings;
  std::string calibration, out, segments_from;
  int cameras = 1;
  bool json = false;
  ReferenceOptions options;
};

void print_summary(const CoreResult& r) {
  std::printf("%s: chi2/dof %.3f, reprojection rms %.2f px (median %.2f px), %d image points, %d iterations\n",
              r.status.c_str(), r.dof > 0 ? r.chi2 / r.dof : 0.0, r.reprojection_rms_px, r.reprojection_median_px,
              r.image_points, r.iterations);
  std::printf("%-14s %14s %12s %-4s %14s  %s\n", "parameter", "value", "sigma", "unit", "initial", "verdict");
  for (const CoreParameter& p : r.parameters) {
    std::printf("%-14s %14.6f %12.6f %-4s %14.6f  %s\n", p.name.c_str(), p.value, p.sigma, p.unit.c_str(), p.initial,
                p.verdict.c_str());
  }
}

ReferenceResult segments(ReferenceArguments& a) {
  const KeptSegments kept = read_kept_segments(a.segments_from);
  const std::string recording = a.recordings.empty() ? "" : a.recordings.front();
  if (!a.calibration.empty()) {
    a.options.start = find_calibration(recording, a.calibration, static_cast<int>(kept.start.cameras.size()));
  }
  return reference_segments(kept, a.options);
}

ReferenceResult batch(ReferenceArguments& a) {
  if (a.recordings.empty())
    throw InputError("expected a recording, or --segments-from DIR (see segcal reference --help)");
  const std::vector<Recording> sessions = read_sessions(a.recordings, a.cameras);
  a.options.calibration = find_calibration(a.recordings.front(), a.calibration, a.cameras);
  a.options.noise = sessions.front().imu.noise;
  return reference_batch(sessions, a.options);
}

int run(ReferenceArguments a) {
  expect_output_folder(a.out, "reference");
  if (!a.segments_from.empty()) check_folder(a.segments_from);
  a.options.progress = [](const std::string& line) { std::cerr << "reference: " << line << std::endl; };
  const ReferenceResult result = a.segments_from.empty() ? batch(a) : segments(a);
  write_reference_files(a.out, result);
  print_summary(result.result);
  return result.result.status == "calibrated" ? 0 : 1;
}

}  // namespace

void add_reference_command(CLI::App& app, int& exit_code) {
  auto a = std::make_shared<ReferenceArguments>();
  CLI::App* sub = app.add_subcommand("reference", reference_explanation);
  sub->footer(examples);
  sub->add_option("recordings", a->recordings, "recordings in ASL layout; several are sessions of one device");
  sub->add_option("--segments-from", a->segments_from,
                  "folder that `segcal replay --out` wrote; the recordings are not read then");
  sub->add_option("--calib", a->calibration,
                  "batch: starting calibration and mean of the prior (default: the recording's own); with "
                  "--segments-from: where the iterations start (default: the prior's mean)");
  sub->add_option("--out", a->out, "folder for the result")->required();
  sub->add_option("--cameras", a->cameras, "cameras to use in a batch, cam0 first")
      ->capture_default_str()
      ->check(CLI::Range(1, 2));
  sub->add_option("--pixel-sigma", a->options.pixel_sigma, "batch: stated noise of a tracked corner per axis, px")
      ->capture_default_str()
      ->check(CLI::PositiveNumber);
  sub->add_option("--threads", a->options.threads, "threads of the solver")
      ->capture_default_str()
      ->check(CLI::Range(1, 64));
  sub->callback([a, &exit_code] { exit_code = run(*a); });
}

}  // namespace host
