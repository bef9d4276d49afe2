// Tables of a recording and trajectories: the first byte says which file the rest is, beside whole ones.
#include <memory>

#include "allan/allan.h"
#include "clock/clock_search.h"
#include "compare/poses.h"
#include "fuzz_files.h"

namespace {

using namespace host;

std::string imu_rows(int n) {
  std::string text = "#timestamp [ns],w_x,w_y,w_z,a_x,a_y,a_z\n";
  for (int i = 0; i < n; ++i) text += std::to_string(1000000000000 + i * 5000000LL) + ",0.1,0.2,-0.1,0.3,0.1,9.8\n";
  return text;
}

std::string track_rows(int n) {
  std::string text = "#timestamp [ns],track_id [],u [px],v [px]\n";
  for (int i = 0; i < n; ++i)
    for (int k = 0; k < 4; ++k)
      text += std::to_string(1000000000000 + i * 100000000LL) + "," + std::to_string(k) + ",320.5,240.25\n";
  return text;
}

const char* const kNames[] = {"mav0/imu0/data.csv",
                              "mav0/cam0/tracks.csv",
                              "mav0/state_groundtruth_estimate0/data.csv",
                              "mav0/cam0/data.csv",
                              "mav0/imu0/gyro.csv",
                              "mav0/imu0/accel.csv",
                              "trajectory.tum",
                              "poses.csv"};
constexpr std::size_t kFiles = sizeof kNames / sizeof *kNames;

/// A recording that is whole but for the one file.
void lay_out(const FuzzFolder& folder, const std::string& file, const std::string& text) {
  std::filesystem::remove_all(folder.path() / "mav0");
  folder.put("mav0/imu0/sensor.yaml",
             "rate_hz: 200\ngyroscope_noise_density: 1e-4\ngyroscope_random_walk: 1e-5\n"
             "accelerometer_noise_density: 1e-3\naccelerometer_random_walk: 1e-4\n");
  const bool streams = file.find("gyro.csv") != std::string::npos || file.find("accel.csv") != std::string::npos;
  static const std::string imu = imu_rows(40), tracks = track_rows(3),
                           axes = "#t,x,y,z\n1000000000000,0,0,1\n1000100000000,0,0,1\n1000200000000,0,0,1\n";
  if (!streams) folder.put(kNames[0], imu);
  if (streams) folder.put(kNames[4], axes);
  if (streams) folder.put(kNames[5], axes);
  folder.put(kNames[1], tracks);
  folder.put(file, text);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const FuzzFolder folder;
  if (size < 1) return 0;
  const std::string text(reinterpret_cast<const char*>(data) + 1, size - 1), name = kNames[data[0] % kFiles];
  if (data[0] % kFiles >= 6) {
    const auto file = folder.put(name, text);
    reads([&] { read_poses(file); });
    return 0;
  }
  lay_out(folder, name, text);
  reads([&] {
    const Recording recording = read_recording(folder.path(), 1, (data[0] & 64) != 0);
    const auto search = [&] { search_clock(recording, CameraCalibration(), 0); };
    if ((data[0] & 128) != 0) search();
  });
  return 0;
}
