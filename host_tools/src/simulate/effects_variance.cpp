#include "effects_variance.h"

#include <Eigen/Geometry>

namespace host::sim {
namespace {

struct Block {
  const char* name;  ///< behind "camN." for the camera's
  std::size_t values;
  const char* unit;
};

constexpr Block camera_blocks[] = {{"r_CI", 3, "rad"}, {"p_CI", 3, "m"}, {"f", 2, "px"}, {"c", 2, "px"}};
constexpr Block imu_blocks[] = {
    {"gyro.s", 3, "-"}, {"gyro.m", 3, "-"}, {"accel.s", 3, "-"}, {"accel.m", 3, "-"}, {"accel.r_AI", 3, "rad"}};

/// The block's full name and what belongs to it; "r_CI" alone is cam0's.
std::pair<std::string, const Block*> find_block(const std::string& name) {
  const bool has_camera = name.rfind("cam0.", 0) == 0 || name.rfind("cam1.", 0) == 0;
  for (const Block& block : camera_blocks) {
    if (name == block.name) return {"cam0." + name, &block};
    if (has_camera && name.substr(5) == block.name) return {name, &block};
  }
  for (const Block& block : imu_blocks)
    if (name == block.name) return {name, &block};
  throw InputError(
      "calibration_shift: expected a block cam0.r_CI, cam0.p_CI, cam0.f, cam0.c, gyro.s, gyro.m, accel.s, accel.m or "
      "accel.r_AI, found '" +
      name + "'");
}

Eigen::Matrix3d rotation(const Eigen::Vector3d& v) {
  return v.norm() > 0 ? Eigen::AngleAxisd(v.norm(), v.normalized()).toRotationMatrix()
                      : Eigen::Matrix3d(Eigen::Matrix3d::Identity());
}

void add_off_diagonal(Eigen::Matrix3d& T, const Eigen::Vector3d& m) {
  T(0, 1) += m.x();
  T(0, 2) += m.y();
  T(1, 2) += m.z();
}

}  // namespace

EffectTruth NoiseFactor::truth() const {
  const bool pixel = factors_.pixel != 1;
  EffectTruth out{pixel ? "pixel_noise" : "imu_noise", {}};
  if (pixel) {
    out.parameters = {{"factor", factors_.pixel, "-"}};
  } else {
    out.parameters = {{"gyro_noise.factor", factors_.gyro, "-"}, {"accel_noise.factor", factors_.accel, "-"}};
  }
  return out;
}

void NoiseFactor::on_noise(NoiseFactors& factors) const {
  factors.gyro *= factors_.gyro;
  factors.accel *= factors_.accel;
  factors.pixel *= factors_.pixel;
}

CalibrationShift::CalibrationShift(const std::string& block, double t, const std::vector<double>& step) : t_(t) {
  const auto [name, found] = find_block(block);
  if (step.size() != found->values)
    throw InputError("calibration_shift=" + block + ": expected a time, s, and " + std::to_string(found->values) +
                     " values, " + found->unit + ", found " + std::to_string(step.size()) + " values");
  block_ = name;
  unit_ = found->unit;
  for (std::size_t i = 0; i < step.size(); ++i) step_[static_cast<Eigen::Index>(i)] = step[i];
}

EffectTruth CalibrationShift::truth() const {
  const std::string end = block_.substr(block_.size() - 2);
  const bool two = end == ".f" || end == ".c";
  EffectTruth out{"calibration_shift", {{"time", t_, "s"}}};
  const char axis[] = {'x', 'y', 'z'};
  for (int i = 0; i < (two ? 2 : 3); ++i) out.parameters.push_back({block_ + "." + axis[i], step_[i], unit_});
  return out;
}

void CalibrationShift::on_camera_calibration(const CameraMoment& moment, CameraCalibration& calibration) const {
  const std::string prefix = "cam" + std::to_string(moment.camera) + ".";
  if (moment.t < t_ || block_.rfind(prefix, 0) != 0) return;
  const std::string part = block_.substr(prefix.size());
  if (part == "r_CI") calibration.R_CI = rotation(step_) * calibration.R_CI;
  if (part == "p_CI") calibration.p_CI += step_;
  if (part == "f") calibration.intrinsics.head<2>() += step_.head<2>();
  if (part == "c") calibration.intrinsics.tail<2>() += step_.head<2>();
}

void CalibrationShift::on_imu_calibration(double t, ImuCalibration& imu) const {
  if (t < t_) return;
  if (block_ == "gyro.s") imu.T_g.diagonal() += step_;
  if (block_ == "gyro.m") add_off_diagonal(imu.T_g, step_);
  if (block_ == "accel.s") imu.T_a.diagonal() += step_;
  if (block_ == "accel.m") add_off_diagonal(imu.T_a, step_);
  if (block_ == "accel.r_AI") imu.R_AI = rotation(step_) * imu.R_AI;
}

}  // namespace host::sim
