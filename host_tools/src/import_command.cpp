// The subcommand `segcal import`: explains the options; Python
// reads the logs (host_tools/importers), where their libraries are.
#include <memory>
#include <string>
#include <vector>

#include "commands.h"
#include "python_script.h"
#include "recording.h"

namespace host {
namespace {

constexpr const char* import_explanation =
    "Makes a recording of a log: ROS bags, MCAP, phone logs, PX4 logs, Aria's VRS, video. REC then works with all "
    "other commands.";

constexpr const char* import_footer = R"(Formats, known by their content:
  ROS 1 bag          run.bag, or all parts of one that was split
  ROS 2 bag          folder with metadata.yaml (SQLite or MCAP), or its .db3 or .mcap alone
  phone log          folder with tables gyro.csv and accel.csv or the like (Sensor Logger, phyphox, ...) or JSON lines, and a
                     table of images (timestamp, filename)
  PX4 log            flight.ulg: sensor_combined, or sensor_gyro and sensor_accel
  EuRoC, TUM-VI      folder with mav0 (needs no import, but may have one)
  Aria               run.vrs of Gen 1 or 2: one IMU and the two front SLAM cameras unless others are named, the factory's calibration.
                     Needs a package, as video does
  video              clip.mp4 with a table of its frames' stamps beside it, clip.csv or frames.csv; with the IMU's tables as
                     further SRC. Needs a package that setup does not install; the message says the command
Several SRC are read together, if their stamps are of one clock.

Examples:
  segcal import run.mcap --list                          what is inside: names, counts, rates
  segcal import run.mcap --out rec                       the one IMU, one or two cameras, their calibration from
                                                         camera_info and /tf_static
  segcal import run.bag --out rec --imu /imu/data --camera /left/image_raw --calib camchain.yaml --imu-noise imu.yaml
  segcal import phone_folder --out rec --mount phone-back --focal 480
  segcal track rec && segcal replay rec --out out        and on to the calibration

Steps of the conversion, each noted in REC/import.json:
  streams   a separate gyroscope and accelerometer are merged: values of the accelerometer are interpolated at
            the gyroscope's stamps; times that one of the two does not cover are dropped
  stamps    the sensors' own; the time of logging where they are missing or run backwards. IMU stamps that scatter like
            those of callbacks are made regular
  units     rad/s and m/s^2; others as the format states, otherwise from the size of gravity and its rotation
  axes      gyroscope and accelerometer must agree on the rotation of gravity; a warning names the axes that would
  copies    a compressed copy of a raw stream and depth images are left out, unless --camera names them
  images    kept as they are where the log has files, else written without loss as PNG; Bayer mosaics become grey
  cameras   lenses with more coefficients than segcal has are replaced by the nearest one; its distance is noted
REC appears whole or not at all. Tracks of your own: REC/mav0/camN/tracks.csv, see docs/formats.md.
Exit code 2: unknown or damaged file, no IMU, or a choice that you must make; one line says which.)";

struct ImportOptions {
  std::vector<std::string> sources, cameras;
  std::string out, imu, gyro, accel, calib, imu_noise, mount, stamps, imu_stamps, gyro_unit, accel_unit, gyro_axes,
      accel_axes;
  double focal = 0;
  bool list = false, json = false;
};

/// What the Python program gets; its names are the same.
std::vector<std::string> arguments_of(const ImportOptions& options) {
  std::vector<std::string> out;
  const std::pair<const char*, const std::string*> texts[] = {{"--out", &options.out},
                                                              {"--imu", &options.imu},
                                                              {"--gyro", &options.gyro},
                                                              {"--accel", &options.accel},
                                                              {"--calib", &options.calib},
                                                              {"--imu-noise", &options.imu_noise},
                                                              {"--mount", &options.mount},
                                                              {"--stamps", &options.stamps},
                                                              {"--imu-stamps", &options.imu_stamps},
                                                              {"--gyro-unit", &options.gyro_unit},
                                                              {"--accel-unit", &options.accel_unit},
                                                              {"--gyro-axes", &options.gyro_axes},
                                                              {"--accel-axes", &options.accel_axes}};
  for (const auto& [name, value] : texts)
    if (!value->empty()) out.push_back(std::string(name) + "=" + *value);
  for (const std::string& camera : options.cameras) out.push_back("--camera=" + camera);
  if (options.focal > 0) out.push_back("--focal=" + std::to_string(options.focal));
  if (options.list) out.push_back("--list");
  if (options.json) out.push_back("--json");
  out.push_back("--");
  out.insert(out.end(), options.sources.begin(), options.sources.end());
  return out;
}

void add_streams(CLI::App& sub, ImportOptions& options) {
  sub.add_option("--imu", options.imu, "stream with rotation rates and accelerations (default: the only one)");
  sub.add_option("--gyro", options.gyro, "stream of the gyroscope, if separate from the accelerometer's");
  sub.add_option("--accel", options.accel, "stream of the accelerometer");
  sub.add_option("--camera", options.cameras,
                 "stream of images; twice for two cameras, cam0 first (default: all, if there are at most two)")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  sub.add_option("--stamps", options.stamps,
                 "sensor: stamps of the messages' headers; log: the time of logging (default: sensor, if set)")
      ->check(CLI::IsMember({"sensor", "log"}));
  sub.add_option("--imu-stamps", options.imu_stamps,
                 "recorded, regular, or auto: regular where they scatter (default: auto)")
      ->check(CLI::IsMember({"auto", "recorded", "regular"}));
}

void add_units(CLI::App& sub, ImportOptions& options) {
  sub.add_option("--gyro-unit", options.gyro_unit, "if the log does not state it, or states it wrongly")
      ->check(CLI::IsMember({"rad/s", "deg/s", "mdeg/s"}));
  sub.add_option("--accel-unit", options.accel_unit, "the same")->check(CLI::IsMember({"m/s^2", "g", "mg"}));
  sub.add_option("--gyro-axes", options.gyro_axes, "new axes by the old ones, such as --gyro-axes=y,-x,z");
  sub.add_option("--accel-axes", options.accel_axes, "the same");
}

void add_calibration(CLI::App& sub, ImportOptions& options) {
  sub.add_option("--calib", options.calib,
                 "starting calibration, Kalibr's camchain-imucam.yaml (default: the log's own)");
  sub.add_option("--imu-noise", options.imu_noise,
                 "noise of the IMU, Kalibr's imu.yaml or `segcal allan`'s (default: a consumer IMU's)");
  sub.add_option("--focal", options.focal, "focal length of a rough start, px, if the log has no calibration")
      ->check(CLI::Range(10.0, 20000.0));
  sub.add_option("--mount", options.mount,
                 "how the camera sits on the IMU, roughly: phone-back (sensor axes of Android and iOS, back camera), "
                 "forward (IMU x forward, y left, z up), same-axes (IMU x right, y down, z forward)")
      ->check(CLI::IsMember({"phone-back", "forward", "same-axes"}));
}

}  // namespace

void add_import_command(CLI::App& app, int& exit_code) {
  CLI::App* const sub = app.add_subcommand("import", import_explanation);
  sub->footer(import_footer);
  const auto options = std::make_shared<ImportOptions>();
  sub->add_option("SRC", options->sources, "log file or folder")->required();
  sub->add_option("--out", options->out, "folder of the recording, new or empty");
  sub->add_flag("--list", options->list, "list the contents, write nothing");
  add_streams(*sub, *options);
  add_calibration(*sub, *options);
  add_units(*sub, *options);
  sub->add_flag("--json", options->json, "print import.json");
  sub->callback([options, &exit_code] {
    if (options->out.empty() && !options->list)
      throw InputError("expected --out REC or --list (see segcal import --help)");
    exit_code = run_python_script("importers/import_recording.py", arguments_of(*options));
  });
}

}  // namespace host
