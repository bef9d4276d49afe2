// What `segcal simulate --help` says around its options.
#pragma once

namespace host {

constexpr const char* simulate_explanation =
    "Simulates a session of a camera and IMU with a known device and writes it as a recording (EuRoC's layout).\n"
    "The starting calibration (REC/camchain-imucam.yaml) is the data sheet's; the device itself is drawn around it.\n"
    "What the device really was is in REC/truth, for evaluation only.";

constexpr const char* simulate_examples = R"(Examples:
  segcal simulate --out rec --scenario arvr --seconds 60 --seed 1
      one minute with a headset; the same command gives the same files
  segcal simulate --out day2 --scenario arvr --seed 2 --device-seed 1
      another session of the same device
  segcal simulate --out stereo --scenario rich --cameras 2 --distortion radtan --pixel-noise 0.3
  segcal simulate --out late --effect time_offset=0.003 --effect gyro_lag=0.004
      a device that departs from the model: REC/truth/truth.json holds the effect, and `segcal diagnose late --out d` should find it
  segcal simulate --out lost --fault frames_dropped_30 && segcal replay lost --out out
      a fault that occurs in the field, and how segcal reports it
  segcal simulate --out twin --model d/model.yaml
      the same departure from the model, in another device
  segcal simulate --out mh03 --trajectory groundtruth.csv --imu imu.csv --seconds 100
      landmarks simulated along a recorded motion, with the real IMU samples
  segcal simulate --out room --images --rate-camera 20 --seconds 20 && segcal track room
      images of a room papered with photographs, for the real tracker; about 0.1 s per image, progress on stderr
  segcal simulate --out phone --images --rate-camera 30 --effect rolling_shutter=3e-5 --exposure 0.015 --grey-noise 4
      a telephone's camera: rows exposed one after another, motion blur, noise

The device is drawn around nominal with 1 px (f, c), 0.004 and 0.002 (gyroscope scale, misalignment), 0.012
(accelerometer scale, misalignment; rotations, rad) and 4 mm. Exit code 2: bad usage or an unusable file.)";

}  // namespace host
