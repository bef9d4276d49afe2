// Writing a recording folder: each file whole or not at all.
#include "exposure_file.h"
#include "file_output.h"
#include "recording.h"

namespace host {
namespace {

namespace fs = std::filesystem;

constexpr int pixel_decimals = 4;

void append_values(std::string& text, const double* values, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) {
    text += ',';
    append_number(text, values[i]);
  }
}

std::string imu_text(const ImuData& imu) {
  std::string text =
      "#timestamp [ns],w_x [rad s^-1],w_y [rad s^-1],w_z [rad s^-1],a_x [m s^-2],a_y [m s^-2],a_z [m s^-2]";
  text += imu.has_temperature ? ",temperature [degC]\n" : "\n";
  for (const ImuSample& sample : imu.samples) {
    append_number(text, sample.t_ns);
    append_values(text, sample.gyro.data(), 3);
    append_values(text, sample.accel.data(), 3);
    if (imu.has_temperature) append_values(text, &sample.temperature_degC, 1);
    text += '\n';
  }
  return text;
}

std::string sensor_text(const ImuNoise& noise) {
  std::string text = "sensor_type: imu\n";
  append_yaml_entry(text, "rate_hz", noise.rate_hz, "Hz");
  append_yaml_entry(text, "gyroscope_noise_density", noise.gyro_noise_density, "rad/s/sqrt(Hz)");
  append_yaml_entry(text, "gyroscope_random_walk", noise.gyro_random_walk, "rad/s^2/sqrt(Hz)");
  append_yaml_entry(text, "accelerometer_noise_density", noise.accel_noise_density, "m/s^2/sqrt(Hz)");
  append_yaml_entry(text, "accelerometer_random_walk", noise.accel_random_walk, "m/s^3/sqrt(Hz)");
  return text;
}

std::string truth_text(const std::vector<TruthPose>& truth) {
  std::string text = "#timestamp [ns],p_x [m],p_y [m],p_z [m],q_w [],q_x [],q_y [],q_z []\n";
  for (const TruthPose& pose : truth) {
    append_number(text, pose.t_ns);
    append_values(text, pose.p_GI.data(), 3);
    append_values(text, pose.q_GI_wxyz.data(), 4);
    text += '\n';
  }
  return text;
}

void append_pixel(std::string& text, double value, bool exact) {
  exact ? append_number(text, value) : append_fixed(text, value, pixel_decimals);
}

}  // namespace

void write_tracks(const fs::path& file, const std::vector<Frame>& frames, bool exact) {
  std::string text = "#timestamp [ns],track_id [],u [px],v [px]\n";
  for (const Frame& frame : frames) {
    for (const TrackPoint& point : frame.points) {
      append_number(text, frame.t_ns);
      text += ',';
      append_number(text, static_cast<std::int64_t>(point.track_id));
      text += ',';
      append_pixel(text, point.u, exact);
      text += ',';
      append_pixel(text, point.v, exact);
      text += '\n';
    }
  }
  write_file(file, text);
}

void write_recording(const Recording& recording) {
  const fs::path mav0 = recording.root / "mav0";
  write_file(mav0 / "imu0" / "sensor.yaml", sensor_text(recording.imu.noise));
  write_file(mav0 / "imu0" / "data.csv", imu_text(recording.imu));
  for (std::size_t i = 0; i < recording.cameras.size(); ++i)
    write_tracks(mav0 / ("cam" + std::to_string(i)) / "tracks.csv", recording.cameras[i].frames,
                 recording.device.has_value());
  if (!recording.cameras.empty()) write_exposures(mav0 / "cam0" / "exposure.csv", recording.cameras.front().frames);
  if (!recording.truth.empty())
    write_file(mav0 / "state_groundtruth_estimate0" / "data.csv", truth_text(recording.truth));
}

}  // namespace host
