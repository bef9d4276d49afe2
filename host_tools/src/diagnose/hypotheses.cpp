#include "diagnose/hypotheses.h"

#include <algorithm>
#include <stdexcept>

#include "diagnose/decision.h"
#include "sensors/effect_catalogue.h"

namespace host::diagnosis {
namespace {

/// Stamps are of the beginning of the exposure, of its middle or of its end.
constexpr double kPlausibleKappa = 0.5;

std::vector<Hypothesis> table() {
  using K = Kind;
  using A = Asks;
  // A gyroscope that is late looks like a camera that is early: time_offset is about both.
  std::vector<Hypothesis> rows = {
      {"time_offset", K::effect, of_timing | of_gyro, A::nothing, "camera and IMU stamps are apart",
       "turns and accelerations that change within a second, before a scene with corners"},
      {"rolling_shutter", K::effect, of_timing, A::nothing,
       "image rows (columns with `readout: columns`) are exposed one after another",
       "quick turns, with tracks at both ends of the read-out: at the top and at the bottom of the image, or left and "
       "right"},
      {"radial_residual", K::effect, of_lens, A::nothing,
       "the lens bends rays more or less than the distortion model says", "tracks out to the corners of the image"},
      {"tangential_residual", K::effect, of_lens, A::nothing,
       "the lens is decentred by more than the distortion model says", "tracks out to all four corners of the image"},
      {"gyro_g_sensitivity", K::effect, of_gyro, A::nothing, "the gyroscope's reading follows the specific force",
       "the device held at many attitudes, and shaken along each axis"},
      {"gyro_nonlinearity", K::effect, of_gyro, A::nothing, "the gyroscope's scale changes with the rate",
       "slow and quick turns about each axis"},
      {"accel_nonlinearity", K::effect, of_accel, A::nothing, "the accelerometer's scale changes with the force",
       "all six faces down, and strong accelerations along each axis"},
      {"gyro_temperature", K::effect, of_gyro, A::temperature, "the gyroscope's bias follows the temperature",
       "a log with temperature, over several degrees"},
      {"accel_temperature", K::effect, of_accel, A::temperature, "the accelerometer's bias follows the temperature",
       "a log with temperature, over several degrees"},
      {"camera_temperature", K::effect, of_lens, A::temperature,
       "the camera's rotation, focal length and principal point follow the temperature",
       "a log with temperature, over several degrees, with turns about each axis and tracks out to the corners"},
      {"gyro_lag", K::effect, of_gyro, A::nothing, "the gyroscope is late against the accelerometer and the camera",
       "turns that begin and end quickly"},
      {"accel_axis_offset", K::effect, of_accel, A::nothing, "the accelerometer's axes sit at different places",
       "quick turns about each axis"},
      {kExposureOffset, K::exposure, of_timing, A::exposures,
       "an image's stamp follows its exposure, as one that is not of the exposure's middle",
       "exposures (mav0/cam0/exposure.csv) that change by several ms, with turns that change within a second",
       kPlausibleKappa},
      {kCalibrationShift, K::step, of_nothing, A::nothing, "the calibration is another one from a moment on",
       "lively motion before and after the shock"},
      {"imu_noise", K::noise, of_nothing, A::nothing, "the IMU's samples are noisier than stated",
       "samples of five seconds"},
      {"pixel_noise", K::noise, of_nothing, A::nothing, "corners are noisier than stated",
       "several corners near each other in one image"},
      {kUnlisted, K::term, of_nothing, A::nothing, "residuals follow a simple term that has no name",
       "livelier motion about and along all axes"},
  };
  for (int e = 0; e < SEGCAL_NS::kEffects; ++e) {
    const SEGCAL_NS::EffectEntry& entry = SEGCAL_NS::effect_entry(e);
    for (Hypothesis& row : rows)
      if (std::string(row.name) == entry.name) row.size = entry.prior_sigma;
  }
  return rows;
}

struct Apart {
  const char *a, *b, *motion;
};

constexpr Apart kApart[] = {
    {"time_offset", "gyro_lag", "accelerations without turns: the accelerometer is not late with the gyroscope"},
    {kExposureOffset, "time_offset", "the same turns in bright light and in dim light"},
    {kExposureOffset, "gyro_lag", "the same turns in bright light and in dim light"},
    {kExposureOffset, kCalibrationShift, "bright and dim light by turns: exposures that change once look like a step"},
    {"time_offset", "rolling_shutter", "quick turns with tracks at the top and at the bottom of the image"},
    {"rolling_shutter", "gyro_lag",
     "turns that begin and end quickly, with tracks at the top and at the bottom of the image"},
    {"radial_residual", "tangential_residual", "tracks out to all four corners of the image"},
    {"gyro_g_sensitivity", "gyro_nonlinearity", "shaking without turns, and turns at rest on a table"},
    {"accel_nonlinearity", "accel_axis_offset", "all six faces down at rest, and quick turns about each axis"},
    {"gyro_temperature", "gyro_g_sensitivity", "a change of temperature while the device keeps its attitude"},
    {"camera_temperature", "gyro_temperature", "turns about each axis while the temperature changes"},
    {"camera_temperature", kCalibrationShift, "the device cooling down again"},
    {"gyro_temperature", "accel_temperature", "a change of temperature at several attitudes"},
};

}  // namespace

const std::vector<Hypothesis>& hypotheses() {
  static const std::vector<Hypothesis> rows = table();
  return rows;
}

const Hypothesis& hypothesis(const std::string& name) {
  for (const Hypothesis& row : hypotheses())
    if (name == row.name) return row;
  throw std::logic_error("no hypothesis '" + name + "'");
}

const std::vector<StepSize>& camera_step_sizes() {
  static const std::vector<StepSize> sizes = {{"r_CI", 3, 0.05, "rad"},
                                              {"p_CI", 3, 0.03, "m"},
                                              {"f", 2, 10, "px"},
                                              {"c", 2, 10, "px"},
                                              {"distortion", 0, 0.03, "-"}};
  return sizes;
}

const std::vector<StepSize>& imu_step_sizes() {
  static const std::vector<StepSize> sizes = {{"gyro.s", 3, 0.02, "-"},
                                              {"gyro.m", 3, 0.02, "-"},
                                              {"accel.s", 3, 0.03, "-"},
                                              {"accel.m", 3, 0.03, "-"},
                                              {"accel.r_AI", 3, 0.03, "rad"}};
  return sizes;
}

const StepSize& step_size(const std::string& block) {
  const bool of_camera = block.rfind("cam", 0) == 0;
  const std::string name = of_camera ? block.substr(block.find('.') + 1) : block;
  for (const StepSize& s : of_camera ? camera_step_sizes() : imu_step_sizes())
    if (name == s.block) return s;
  throw std::logic_error("no step of '" + block + "'");
}

double share_of(Kind kind, bool has_exposures) {
  switch (kind) {
    case Kind::step: return decision::kStepsShare;
    case Kind::term: return decision::kDictionaryShare;
    case Kind::noise: return 0;
    default: return has_exposures ? decision::kShareWithExposures : decision::kCatalogueShare;
  }
}

std::string needs(const std::string& effect) {
  return hypothesis(effect.empty() ? std::string(kUnlisted) : effect).needs;
}

std::string separates(const std::string& a, const std::string& b) {
  for (const Apart& p : kApart) {
    if ((a == p.a && b == p.b) || (a == p.b && b == p.a)) return p.motion;
  }
  return needs(a) + "; " + needs(b);
}

}  // namespace host::diagnosis
