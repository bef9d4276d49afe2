// Departures of the real sensors from the calibrated model. The simulator calls each hook in one place.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "../calibration_file.h"
#include "../recording.h"
#include "temperature.h"
#include "trajectory.h"

namespace host::sim {

/// One reading of the IMU: rad/s in the gyroscope's axes, m/s^2 in the accelerometer's.
struct ImuReading {
  Eigen::Vector3d gyro = Eigen::Vector3d::Zero();
  Eigen::Vector3d accel = Eigen::Vector3d::Zero();
};

/// What an IMU reading can depend on.
struct ImuMoment {
  double t;  ///< s since the first frame
  const Trajectory& truth;
  const ImuCalibration& imu;  ///< of this moment
  const BodyState& state;     ///< truth.at(t)
  Eigen::Vector3d force_I;    ///< specific force in I, m/s^2
  double temperature_degC;    ///< 25 where the simulation has no temperature
};

/// What a camera's calibration can depend on.
struct CameraMoment {
  double t;            ///< s since the first frame
  std::size_t camera;  ///< 0: the first
  double temperature_degC = reference_temperature_degC;
};

/// Factors on the standard deviation of the white noise; the files go on stating the noise without them.
struct NoiseFactors {
  double gyro = 1, accel = 1, pixel = 1;
};

/// What an effect is, for truth/truth.json: parameters named as in result files.
struct EffectTruth {
  struct Parameter {
    std::string name;  ///< without the effect's name and its dot
    double value;
    std::string unit;
  };
  std::string name;
  std::vector<Parameter> parameters;
};

/// An effect overrides the hooks that it needs; what is not overridden changes nothing. Effects must not keep state
/// between calls that depends on the order of cameras; IMU hooks come in order of time.
class Effect {
 public:
  virtual ~Effect() = default;

  virtual EffectTruth truth() const { return {}; }

  /// Changes a reading after scale, misalignment and rotation, before bias and noise.
  virtual void on_imu(const ImuMoment&, ImuReading&) const {}

  /// Time on the IMU's clock, s, at which a line of the image (row, or column where the
  /// camera reads columns), px, of the frame stamped `t_stamp`, s, was exposed.
  /// Several effects are applied one after another.
  virtual double exposure_time(const CameraCalibration&, double t_stamp, double /*line*/) const { return t_stamp; }

  /// From the stamp of an image to the middle of its exposure, s; 0 where stamps are of the middle.
  virtual double after_stamp(double /*exposure, s*/) const { return 0; }

  /// Moves an ideal pixel to where the real lens puts it. `t` in s since the first frame.
  virtual void on_pixel(const CameraCalibration&, double /*t*/, Eigen::Vector2d& /*pixel*/) const {}

  /// Does it? What is ideally outside of the image may be inside then.
  virtual bool moves_pixels() const { return false; }

  /// What has become of the device by then: a shock, another temperature.
  virtual void on_camera_calibration(const CameraMoment&, CameraCalibration&) const {}
  virtual void on_imu_calibration(double /*t, s*/, ImuCalibration&) const {}

  virtual void on_noise(NoiseFactors&) const {}

  /// Changes the finished log: faults of the sensors' electronics and of the logger.
  virtual void on_log(Recording&, std::uint64_t /*seed*/) const {}

  /// Acts on the simulated IMU samples: no use with real ones.
  virtual bool needs_simulated_imu() const { return false; }
  virtual bool needs_temperature() const { return false; }
  virtual bool needs_exposures() const { return false; }
};

using Effects = std::vector<std::shared_ptr<const Effect>>;

/// Of all effects.
double after_stamp(const Effects& effects, double exposure_s);

}  // namespace host::sim
