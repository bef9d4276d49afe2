// The subcommand `segcal export`: a calibration in the files of other tools (host_tools/exporters).
#include <memory>
#include <string>
#include <vector>

#include "commands.h"
#include "files/manifest.h"
#include "python_script.h"
#include "recording.h"

namespace host {
namespace {

namespace fs = std::filesystem;

constexpr const char* export_explanation =
    "Writes a calibration as Kalibr, OpenVINS, Basalt or ROS read it, or a whole session for a viewer: as MCAP with "
    "the messages of Foxglove and Lichtblick, or for rerun.";

constexpr const char* export_footer =
    R"(DIR is what `segcal replay --out DIR` wrote (or any folder with camchain-imucam.yaml and imu.yaml). Written to --out:
  kalibr     camchain-imucam.yaml, imu.yaml (model scale-misalignment: lower triangular M, body frame of the accelerometer)
  openvins   kalibr_imucam_chain.yaml, kalibr_imu_chain.yaml (model rpng, frame of the gyroscope as here)
  basalt     calibration.json
  ros        camN.yaml for camera_info_manager and camera_calibration_parsers, transforms.yaml

  mcap       session.mcap: calibration, path, map, the recording with --rec (images, IMU, corner tracks), and the verdict as log messages

  rerun      session.rrd: the same for rerun. Needs a package that setup does not install; the message says the command

  segcal export out --to openvins --out openvins_config
  segcal export out --to mcap --rec REC --out view         then open view/session.mcap

Frames are converted exactly: where another tool's IMU frame is the accelerometer's, the camera's pose is converted too.
A lens that the other tool lacks is replaced by its nearest one; the distance is printed on stderr. Biases are states of the
device, not calibration; they are written as zero. Exit code 2: DIR has no calibration, or it cannot be read.)";

struct ExportOptions {
  std::string folder, to, out, recording;
  bool no_images = false;
};

}  // namespace

void add_export_command(CLI::App& app, int& exit_code) {
  CLI::App* const sub = app.add_subcommand("export", export_explanation);
  sub->footer(export_footer);
  const auto options = std::make_shared<ExportOptions>();
  sub->add_option("DIR", options->folder, "folder with camchain-imucam.yaml and imu.yaml")->required();
  sub->add_option("--to", options->to, "kalibr, openvins, basalt, ros, mcap or rerun")
      ->required()
      ->check(CLI::IsMember({"kalibr", "openvins", "basalt", "ros", "mcap", "rerun"}));
  sub->add_option("--out", options->out, "folder to write into")->required();
  sub->add_option("--rec", options->recording, "mcap, rerun: the recording that DIR was made from");
  sub->add_flag("--no-images", options->no_images, "mcap, rerun: leave the images of --rec out");
  sub->callback([options, &exit_code] {
    if (!fs::exists(fs::path(options->folder) / "camchain-imucam.yaml"))
      throw InputError((fs::path(options->folder) / "camchain-imucam.yaml").string() +
                       ": file is missing; `segcal replay --out` writes it");
    check_folder(options->folder);
    const bool viewer = options->to == "mcap" || options->to == "rerun";
    if (!viewer && (!options->recording.empty() || options->no_images))
      throw InputError("--rec and --no-images: for --to mcap and rerun only");
    std::vector<std::string> arguments = {options->folder, options->to, options->out};
    if (!options->recording.empty()) arguments.push_back("--rec=" + options->recording);
    if (options->no_images) arguments.push_back("--no-images");
    exit_code = run_python_script("exporters/export.py", arguments);
  });
}

}  // namespace host
