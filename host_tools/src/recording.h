// A recording on disk: EuRoC's ASL folder layout (docs/formats.md, "A recording"), read and written.
// Readers check everything and throw InputError with file, line and what was expected; writers write to a
// temporary name first and rename, so that nothing half-written is ever left.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace host {

/// Bad usage or bad input: the program prints `what()` as one line and ends with exit code 2.
struct InputError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// One IMU sample, raw sensor values.
struct ImuSample {
  std::int64_t t_ns = 0;          ///< stamp, IMU clock, ns
  std::array<double, 3> gyro{};   ///< rad/s, gyroscope axes
  std::array<double, 3> accel{};  ///< m/s^2, accelerometer axes (specific force)
  double temperature_degC = 0;    ///< only where ImuData::has_temperature
};

/// Noise as in Kalibr's imu.yaml and EuRoC's imu0/sensor.yaml.
struct ImuNoise {
  double rate_hz = 200;
  double gyro_noise_density = 1.7e-4;  ///< rad/s/sqrt(Hz)
  double gyro_random_walk = 2e-5;      ///< rad/s^2/sqrt(Hz)
  double accel_noise_density = 2e-3;   ///< m/s^2/sqrt(Hz)
  double accel_random_walk = 3e-4;     ///< m/s^3/sqrt(Hz)
};

/// Temperature readings that jump away and back (imu_temperature.h).
struct TemperatureJumps {
  std::size_t count = 0, of = 0;  ///< readings; none: all is well
  std::int64_t first_ns = 0, last_ns = 0;
  double share = 0, farthest_K = 0;
  bool bridged = false;  ///< the one before was held in their place; else temperature is not to be used
};

struct ImuData {
  ImuNoise noise;
  bool has_temperature = false;
  TemperatureJumps temperature_jumps;
  /// in file order; data faults (repeats, NaN, gaps) are left in, the core counts them
  std::vector<ImuSample> samples;
};

/// One tracked corner in one image, raw distorted pixels.
struct TrackPoint {
  std::uint32_t track_id = 0;
  double u = 0, v = 0;  ///< px
};

/// All corners of one image.
struct Frame {
  std::int64_t t_ns = 0;  ///< stamp, camera clock, ns
  std::vector<TrackPoint> points;
  double exposure_s = 0;  ///< for how long the first camera exposed its image of this stamp; 0: nobody says
};

/// One image on disk.
struct ImageEntry {
  std::int64_t t_ns = 0;
  std::filesystem::path file;
};

struct CameraData {
  std::vector<ImageEntry> images;  ///< from camN/data.csv; empty where the folder has only tracks
  std::vector<Frame> frames;       ///< from camN/tracks.csv; empty where that file is absent
  std::vector<Frame> strays;       ///< frames whose stamps lie apart, set aside by the reader (stamps/stray_frames.h)
};

/// One pose of the ground truth (evaluation only, never fed to an estimator).
struct TruthPose {
  std::int64_t t_ns = 0;
  std::array<double, 3> p_GI{};                   ///< m
  std::array<double, 4> q_GI_wxyz{{1, 0, 0, 0}};  ///< Hamilton, unit, rotates I into G
};

/// One call that a device made, in a recording that it made itself.
struct DeviceCall {
  enum What { sample, frame, flush, calibrate, hash, request };
  What what = sample;            ///< sample, frame: the next one of the recording
  std::uint64_t hash_value = 0;  ///< the device's result hash at this place
  bool late = false;             ///< a sample or frame that found background work due and not done
};

/// What a recording made on a device (device_log/device_log.h) says beside its data.
struct DeviceSession {
  std::vector<DeviceCall> calls;
  std::vector<std::uint8_t> config;  ///< its configuration, as lib/src/log/config_fields.h reads it
  std::string profile;               ///< whose capacities it has; empty: none of ours
  std::string state;                 ///< it begins with the device's: flash (state/flash_image.h); empty: as created
  bool last = true;                  ///< of its sessions
  bool was_late = false;             ///< some call found work due and not done
};

struct Recording {
  std::filesystem::path root;
  ImuData imu;
  std::vector<CameraData> cameras;      ///< cam0, cam1, ...
  std::vector<TruthPose> truth;         ///< empty where the folder has none
  std::vector<std::string> notes;       ///< what was done to the data while they were read, a sentence each
  std::optional<DeviceSession> device;  ///< of a device log; then all cameras have the same frames, some of them empty
};

/// Reads REC/mav0. `n_cameras` cameras must exist. Frames come from tracks.csv; where it is missing, `frames` stays
/// empty (the caller decides whether that is an error: `segcal replay` says to run `segcal track` first).
/// Exposure times come from cam0/exposure.csv, if it is there (exposure_file.h), by the stamps as they are in the
/// files. The IMU comes from imu0/data.csv or, where that is missing, from gyro.csv and accel.csv
/// (stamps/imu_streams.h). `smooth`: stamps of IMU and tracks are those of callbacks and are smoothed
/// (stamps/smooth_stamps.h). `replacing`: the command that reads it to replace its own files in it (files/manifest.h);
/// `track` reads no tracks. Throws InputError: files that do not belong together, missing or empty file, wrong column
/// count, non-number, no overlap of IMU and camera in time.
Recording read_recording(const std::filesystem::path& root, int n_cameras, bool smooth = false,
                         std::string_view replacing = {});

/// Writes imu0/{data.csv,sensor.yaml}, camN/{data.csv-less, tracks.csv}, cam0/exposure.csv (if
/// frames have exposures), state_groundtruth_estimate0/data.csv (if truth).
void write_recording(const Recording& recording);

/// Writes camN/tracks.csv of one camera (used by `segcal track` as well). Pixels with four decimals, far below any
/// tracker's noise; `exact`: so that they read back to the same.
void write_tracks(const std::filesystem::path& file, const std::vector<Frame>& frames, bool exact = false);

/// The data folder for optional real recordings: $SEGCAL_DATA,
/// else ../shared/data beside the source tree, if it exists.
std::optional<std::filesystem::path> find_real_data();

}  // namespace host
