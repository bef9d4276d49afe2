#include "diagnose/catalogue.h"

namespace host::diagnosis {
namespace {

struct Words {
  const char *effect, *looks_like, *needs;
};

constexpr Words kWords[] = {
    {"time_offset", "camera and IMU stamps are apart",
     "turns and accelerations that change within a second, before a scene with corners"},
    {"rolling_shutter", "image rows (columns with `readout: columns`) are exposed one after another",
     "quick turns, with tracks at both ends of the read-out: at the top and at the bottom of the image, or left and "
     "right"},
    {"radial_residual", "the lens bends rays more or less than the distortion model says",
     "tracks out to the corners of the image"},
    {"tangential_residual", "the lens is decentred by more than the distortion model says",
     "tracks out to all four corners of the image"},
    {"gyro_g_sensitivity", "the gyroscope's reading follows the specific force",
     "the device held at many attitudes, and shaken along each axis"},
    {"gyro_nonlinearity", "the gyroscope's scale changes with the rate", "slow and quick turns about each axis"},
    {"accel_nonlinearity", "the accelerometer's scale changes with the force",
     "all six faces down, and strong accelerations along each axis"},
    {"gyro_temperature", "the gyroscope's bias follows the temperature",
     "a log with temperature, over several degrees"},
    {"accel_temperature", "the accelerometer's bias follows the temperature",
     "a log with temperature, over several degrees"},
    {"gyro_lag", "the gyroscope is late against the accelerometer and the camera", "turns that begin and end quickly"},
    {"accel_axis_offset", "the accelerometer's axes sit at different places", "quick turns about each axis"},
    {"camera_temperature", "the camera's rotation, focal length and principal point follow the temperature",
     "a log with temperature, over several degrees, with turns about each axis and tracks out to the corners"},
    {"exposure_offset", "an image's stamp follows its exposure, as one that is not of the exposure's middle",
     "exposures (mav0/cam0/exposure.csv) that change by several ms, with turns that change within a second"},
    {"calibration_shift", "the calibration is another one from a moment on",
     "lively motion before and after the shock"},
};

const Words* find(const std::string& effect) {
  for (const Words& w : kWords) {
    if (effect == w.effect) return &w;
  }
  return nullptr;
}

struct Apart {
  const char *a, *b, *motion;
};

constexpr Apart kApart[] = {
    {"time_offset", "gyro_lag", "accelerations without turns: the accelerometer is not late with the gyroscope"},
    {"exposure_offset", "time_offset", "the same turns in bright light and in dim light"},
    {"exposure_offset", "gyro_lag", "the same turns in bright light and in dim light"},
    {"exposure_offset", "calibration_shift",
     "bright and dim light by turns: exposures that change once look like a step"},
    {"time_offset", "rolling_shutter", "quick turns with tracks at the top and at the bottom of the image"},
    {"rolling_shutter", "gyro_lag",
     "turns that begin and end quickly, with tracks at the top and at the bottom of the image"},
    {"radial_residual", "tangential_residual", "tracks out to all four corners of the image"},
    {"gyro_g_sensitivity", "gyro_nonlinearity", "shaking without turns, and turns at rest on a table"},
    {"accel_nonlinearity", "accel_axis_offset", "all six faces down at rest, and quick turns about each axis"},
    {"gyro_temperature", "gyro_g_sensitivity", "a change of temperature while the device keeps its attitude"},
    {"camera_temperature", "gyro_temperature", "turns about each axis while the temperature changes"},
    {"camera_temperature", "calibration_shift", "the device cooling down again"},
    {"gyro_temperature", "accel_temperature", "a change of temperature at several attitudes"},
};

}  // namespace

std::string looks_like(const std::string& effect) {
  const Words* w = find(effect);
  return w ? w->looks_like : effect;
}

std::string needs(const std::string& effect) {
  const Words* w = find(effect);
  return w ? w->needs : "livelier motion about and along all axes";
}

std::string separates(const std::string& a, const std::string& b) {
  for (const Apart& p : kApart) {
    if ((a == p.a && b == p.b) || (a == p.b && b == p.a)) return p.motion;
  }
  return needs(a) + "; " + needs(b);
}

}  // namespace host::diagnosis
