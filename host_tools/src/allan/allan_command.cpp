// The subcommand `segcal allan`: noise of an IMU from a recording at rest, as the imu.yaml that other commands take.
#include <cstdio>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "allan/allan.h"
#include "commands.h"
#include "files/output_run.h"
#include "imu_data_file.h"
#include "python_script.h"
#include "recording.h"

namespace host {
namespace {

namespace fs = std::filesystem;

constexpr const char* allan_explanation =
    "Measures noise densities and bias walks of an IMU from a recording at rest (overlapping Allan deviation).";

constexpr const char* allan_footer =
    R"(Put the device on an undisturbed table and record its IMU: a minute gives the noise densities to 5 %, an hour the
bias walks. REC needs no images. The longest rest in it is used.

  segcal import rest.mcap --out rest       any log; without images too
  segcal allan rest --out noise            noise/imu.yaml, noise/report.html: deviation against averaging time
  segcal import run.mcap --out rec --imu-noise noise/imu.yaml

Each axis is fitted by deviation^2 = N^2 / tau + B^2 2 ln2 / pi + K^2 tau / 3: white noise N, bias instability B, bias walk K.
imu.yaml holds the largest of the three axes. If the rest is too short for a walk, its upper bound is written
(two sigmas above the fit), with a message.

In motion an IMU is noisier than on a table (vibration, scale errors in fast turns, the clock). Do not guess a factor:
`segcal diagnose` on a recording of the motion measures it (imu_noise).

Exit code 1: not at rest, too short, or samples missing; one line says which. 2: REC cannot be read.)";

nlohmann::json json_of(const SensorFit& fit) {
  nlohmann::json axes = nlohmann::json::array(), points = nlohmann::json::array();
  for (const AxisFit& a : fit.axes)
    axes.push_back({{"density", a.density},
                    {"instability", a.instability},
                    {"walk", a.walk},
                    {"walk_sigma", a.walk_sigma},
                    {"walk_seen", a.walk_seen}});
  for (const AllanPoint& p : fit.points) points.push_back({p.tau_s, p.deviation[0], p.deviation[1], p.deviation[2]});
  return {{"density", fit.density()},
          {"walk", fit.walk()},
          {"walk_seen", fit.walk_seen()},
          {"axes", axes},
          {"points", points}};
}

void append_figure(std::string& text, const char* name, double value, const char* unit, const std::string& remark) {
  append_yaml_entry(text, name, value, unit + remark);
}

std::string yaml_of(const AllanResult& r) {
  char head[160];
  std::snprintf(head, sizeof head,
                "# By Allan deviation over a rest of %.0f s at %.1f Hz; the largest of three axes each.\n", r.rest_s,
                r.rate_hz);
  std::string text = head;
  const auto remark = [](const SensorFit& fit) {
    return fit.walk_seen() ? std::string() : std::string(", not seen in this rest: the most that it may be");
  };
  text += "rostopic: /imu0\n";
  append_figure(text, "update_rate", r.rate_hz, "Hz", "");
  append_figure(text, "accelerometer_noise_density", r.accel.density(), "m/s^2/sqrt(Hz)", "");
  append_figure(text, "accelerometer_random_walk", r.accel.walk(), "m/s^3/sqrt(Hz)", remark(r.accel));
  append_figure(text, "gyroscope_noise_density", r.gyro.density(), "rad/s/sqrt(Hz)", "");
  append_figure(text, "gyroscope_random_walk", r.gyro.walk(), "rad/s^2/sqrt(Hz)", remark(r.gyro));
  return text;
}

void print_sensor(const char* name, const SensorFit& fit, const char* unit, const char* density_unit,
                  const char* walk_unit) {
  std::printf("%s\n", name);
  for (std::size_t i = 0; i < 3; ++i) {
    const AxisFit& a = fit.axes[i];
    std::printf("  %c  noise density %.3g %s, bias instability %.2g %s, walk %s%.2g %s\n", "xyz"[i], a.density,
                density_unit, a.instability, unit, a.walk_seen ? "" : "below ", a.walk, walk_unit);
  }
}

int run(const fs::path& root, const fs::path& out, bool as_json) {
  expect_output_folder(out, "allan");
  check_folder(root);
  AllanResult result;
  try {
    result = allan_of(read_imu_samples(root / "mav0" / "imu0" / "data.csv").samples);
  } catch (const NotAtRest& why) {
    std::cerr << "segcal: " << root.string() << ": " << why.what() << '\n';
    return 1;
  }
  const nlohmann::json json = {{"format", 1},
                               {"rate_hz", result.rate_hz},
                               {"start_s", result.start_s},
                               {"rest_s", result.rest_s},
                               {"gyro", json_of(result.gyro)},
                               {"accel", json_of(result.accel)}};
  OutputRun files(out, "allan");
  write_file(out / "allan.json", json.dump(2) + "\n");
  write_file(out / "imu.yaml", yaml_of(result));
  files.finish();
  if (as_json) {
    std::cout << json.dump(2) << '\n';
  } else {
    std::printf("%s: rest of %.1f s, from %.1f s on, %.1f Hz\n", root.string().c_str(), result.rest_s, result.start_s,
                result.rate_hz);
    print_sensor("gyroscope", result.gyro, "rad/s", "rad/s/sqrt(Hz)", "rad/s^2/sqrt(Hz)");
    print_sensor("accelerometer", result.accel, "m/s^2", "m/s^2/sqrt(Hz)", "m/s^3/sqrt(Hz)");
    std::printf("%s\n", (out / "imu.yaml").string().c_str());
  }
  std::fflush(stdout);
  return run_python_script("report/report.py", {out.string()});
}

}  // namespace

void add_allan_command(CLI::App& app, int& exit_code) {
  CLI::App* const sub = app.add_subcommand("allan", allan_explanation);
  sub->footer(allan_footer);
  const auto root = std::make_shared<fs::path>(), out = std::make_shared<fs::path>();
  const auto as_json = std::make_shared<bool>(false);
  sub->add_option("REC", *root, "recording with at least one minute at rest")->required();
  sub->add_option("--out", *out, "folder for imu.yaml, allan.json and report.html")->required();
  sub->add_flag("--json", *as_json, "print allan.json");
  sub->callback([root, out, as_json, &exit_code] { exit_code = run(*root, *out, *as_json); });
}

}  // namespace host
