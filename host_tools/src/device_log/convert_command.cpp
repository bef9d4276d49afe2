// segcal convert: device logs to recording folders and back.
#include <iostream>

#include "commands.h"
#include "device_log/device_log.h"
#include "device_log/write_log.h"
#include "files/output_run.h"
#include "replay/sessions.h"

namespace host {
namespace {

namespace fs = std::filesystem;

struct ConvertArguments {
  std::vector<std::string> recordings;
  std::string calibration, out, profile = "mobile";
  int cameras = 1;
  bool salvage = false;
  double pixel_sigma = 0.5;
};

/// One session into the folder itself, several into folders 0, 1, ... in it.
int to_folders(const ConvertArguments& a) {
  if (a.recordings.size() > 1)
    throw InputError("expected one device log at a time, found " + std::to_string(a.recordings.size()));
  DeviceLog log = read_device_log(a.recordings.front(), a.salvage ? Damaged::leave_out : Damaged::refuse);
  for (const std::string& note : log.notes) std::cerr << "segcal: " << note << std::endl;
  if (!log.sessions.front().device->state.empty())
    std::cerr << "segcal: " << a.recordings.front()
              << ": the device's state that it begins with is left out: a folder holds data only" << std::endl;
  for (std::size_t i = 0; i < log.sessions.size(); ++i) {
    Recording& session = log.sessions[i];
    session.root = log.sessions.size() == 1 ? fs::path(a.out) : fs::path(a.out) / std::to_string(i);
    expect_output_folder(session.root, "convert", true);
    OutputRun run(session.root, "convert");
    write_recording(session);
    write_camchain(session.root / "camchain-imucam.yaml", log.calibration);
    write_imu_yaml(session.root / "imu.yaml", log.calibration, log.noise);
    run.finish();
    std::cout << session.root.string() << ": " << session.imu.samples.size() << " IMU samples, "
              << session.cameras[0].frames.size() << " frames" << std::endl;
  }
  return 0;
}

int to_log(const ConvertArguments& a) {
  const std::vector<Recording> sessions = read_sessions(a.recordings, a.cameras);
  CoreOptions options;
  options.calibration = find_calibration(a.recordings.front(), a.calibration, a.cameras);
  options.noise = sessions.front().imu.noise;
  options.pixel_sigma = a.pixel_sigma;
  const std::vector<std::uint8_t> bytes = device_log_of(sessions, options, a.profile);
  write_file(a.out, std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
  std::cout << a.out << ": " << bytes.size() << " bytes" << std::endl;
  return 0;
}

}  // namespace

void add_convert_command(CLI::App& app, int& exit_code) {
  auto a = std::make_shared<ConvertArguments>();
  CLI::App* sub = app.add_subcommand("convert", "device log to recording folder, or recording folders to a device log");
  sub->add_option("recordings", a->recordings,
                  "a device log (*.segcal), or recordings in ASL layout with tracks, sessions in order")
      ->required();
  sub->add_option("--out", a->out, "the folder, or the file NAME.segcal, to write")->required();
  sub->add_option("--calib", a->calibration, "starting calibration to store in the log (default: the recording's own)");
  sub->add_option("--cameras", a->cameras, "cameras that go into the log, cam0 first")
      ->capture_default_str()
      ->check(CLI::Range(1, 2));
  sub->add_option("--pixel-sigma", a->pixel_sigma,
                  "stated noise of a tracked corner per axis that goes into the log, px")
      ->capture_default_str()
      ->check(CLI::PositiveNumber);
  sub->add_option("--profile", a->profile, "capacities that the log is for: mcu, mobile, host, mobile_double")
      ->capture_default_str();
  sub->add_flag("--salvage", a->salvage, "skip damaged blocks of a log, with a line for each");
  sub->footer(R"(Examples:
  segcal convert flight.segcal --out rec
  segcal convert rec --profile mcu --out rec.segcal && segcal replay rec.segcal --out out

Samples and pixels keep all bits in both directions: a device has them in single precision, and the folder's texts read back to the
same. A folder cannot hold everything; lost are the device's further configuration, the
state that a log may begin with, frames without a corner, result hashes.
A log has no exposures (cam0/exposure.csv): they stay with the folder.

A truncated log is read up to its end. A log with damage in the middle is refused, because a hole in the data gives a result
that differs from the device's; with --salvage the rest is converted.)");
  sub->callback([a, &exit_code] { exit_code = is_device_log(a->recordings.front()) ? to_folders(*a) : to_log(*a); });
}

}  // namespace host
