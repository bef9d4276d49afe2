// Simulation of a camera and IMU session with a known device and known motion: `segcal simulate`, and for tests without
// a disk. Everything is double and written apart from the core, so that agreement between the two means something.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "../calibration_file.h"
#include "../recording.h"
#include "camera_simulator.h"
#include "imu_simulator.h"
#include "replica.h"
#include "trajectory.h"

namespace host {

struct SimulationOptions {
  std::string scenario = "rich";             ///< a name of sim::scenarios()
  double seconds = 60;                       ///< from the first to the last frame; 1 to 36000
  std::uint64_t seed = 1;                    ///< motion, scene, noise, biases
  std::optional<std::uint64_t> device_seed;  ///< the specimen; empty: the same as `seed`
  double device_scale = 1;                   ///< factor on the scatter of devices; 0 simulates the nominal device
  std::function<void(Calibration&)> change_device;  ///< what happened to the specimen since it was made; empty: nothing
  DistortionModel distortion = DistortionModel::fov;
  bool reads_columns = false;              ///< a rolling shutter runs across the image
  int cameras = 1;                         ///< 1 or 2
  bool stereo_matches = true;              ///< corners seen by both cameras have one track id in both; false: never
  double camera_rate_hz = 10;              ///< Hz
  ImuNoise imu_noise;                      ///< rate and noise that are written to sensor.yaml and simulated
  bool with_imu_noise = true;              ///< false: no white noise and no biases
  bool exposures = false;                  ///< the frames have exposure times, also without an effect that needs them
  bool images = false;                     ///< frames without tracks, for render::write_images
  sim::TrackOptions tracks;                ///< number, life span and pixel noise
  sim::Effects effects;                    ///< departures from the model, applied in this order
  std::optional<sim::WarmUp> temperature;  ///< of the IMU; empty: recorded only if an effect needs it
  std::filesystem::path trajectory_file;   ///< recorded poses to follow instead of `scenario`; empty: none
  std::filesystem::path imu_file;          ///< real IMU samples instead of simulated ones, needs `trajectory_file`
  std::optional<sim::Replica> replica;     ///< motion, scene and device of a recording; scenario and seed of the device
                                           ///< then count for nothing
};

/// The truth at one moment.
struct TruthState {
  sim::BodyState body;  ///< R_GI, p_GI, v_GI, a_GI, w_GI
  sim::Biases biases;   ///< zero where the IMU samples are real
};

struct SimulationResult {
  Recording recording;  ///< root is empty; `truth` holds the pose at each IMU stamp
  Calibration nominal;  ///< what an estimator starts from
  Calibration truth;    ///< the simulated specimen, before any shock
  std::vector<sim::EffectTruth> effects;
  bool with_images = false;      ///< the frames have stamps only
  bool imu_is_simulated = true;  ///< false with `imu_file`: the IMU part of `truth` is unknown then
  sim::Trajectory trajectory;    ///< times in s since `time_zero_ns`
  sim::BiasHistory biases;
  sim::WarmUp warm_up = sim::no_warm_up();  ///< the temperature, which is constant where the recording has none
  std::int64_t time_zero_ns = 0;
  std::uint64_t device_seed = 0;    ///< the specimen
  std::vector<double> frame_times;  ///< what each frame's stamp was before faults of the log, s since `time_zero_ns`

  /// Truth at a stamp of the IMU's clock, ns; stamps outside the recording are clamped.
  TruthState state_at(std::int64_t t_ns) const;
};

/// Simulates; deterministic in the options. `progress`, if given, is called with 0 to 1 now and then.
/// Throws InputError for an unknown scenario, a value outside its range, or an unusable file.
SimulationResult simulate(const SimulationOptions& options, const std::function<void(double)>& progress = {});

/// Writes the recording, camchain-imucam.yaml (nominal) and truth/ (camchain-imucam.yaml, imu.yaml, truth.json,
/// biases.csv) under `root`; of a session with images no tracks. Throws InputError if the disk refuses.
void write_simulation(const SimulationResult& result, const std::filesystem::path& root);

}  // namespace host
