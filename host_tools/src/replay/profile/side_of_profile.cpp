#include "replay/profile/side_of_profile.h"

#include <algorithm>

#include "replay/profile/segment_in_double.h"
#include "replay/profile/sensor_rows_of_profile.h"

namespace host {
namespace SEGCAL_NS {
namespace {

/// Theta is held by this share of the prior's sigmas: what a side hardly tells stays where both sides together have it.
constexpr double kHeld = 0.1;
/// Of each of two runs: rows need a place near the best one to be linearised at, not the best one.
constexpr int kIterations = 2;
/// As a calibration has it (api/calibrate_job.h).
constexpr double kOutlierSigmas = 5;

/// Each segment by itself, as the rows before and after a step are (diagnose/shift.h): sessions of their own, which
/// share neither states nor landmarks.
std::unique_ptr<core::Segment<double>> alone(const core::Segment<core::Real>& in, int place, double gyro_range,
                                             double accel_range) {
  auto out = in_double(in, gyro_range, accel_range);
  out->serial = in.serial;
  out->session = out->frame = static_cast<std::uint32_t>(place);
  return out;
}

class Side final : public CoreSide {
 public:
  Side(const core::DeviceOptions<core::Real>& options, const core::Calibration<core::Real>& theta,
       const std::vector<const core::Segment<core::Real>*>& segments, const std::vector<double>& expected)
      : model_(in_double(options.model)) {
    for (const core::Segment<core::Real>* s : segments)
      segment_.push_back(alone(*s, static_cast<int>(segment_.size()), options.gyro_range, options.accel_range));
    const core::Calibration<double> fitted = in_double(theta);
    prior_.mean = fitted;
    core::add_step(&prior_.mean, expected.data());
    for (int i = 0; i < fitted.columns(); ++i) prior_.sigma[i] = kHeld * static_cast<double>(options.prior.sigma[i]);
    fit();
    moved_.resize(static_cast<std::size_t>(fitted.columns()));
    core::difference(fitted, calibrator_->theta(), moved_.data());
  }

  const std::vector<double>& moved() const override { return moved_; }
  double chi2_per_dof() const override { return chi2_per_dof_; }
  std::int64_t work() const override { return work_; }

  CoreRows linearise(const std::vector<std::uint32_t>& serials, const std::vector<CoreTerm>& candidates) override {
    bool use[core::kMaxSegments] = {};
    for (std::size_t i = 0; i < segment_.size(); ++i)
      use[i] = std::count(serials.begin(), serials.end(), segment_[i]->serial) > 0;
    CoreRows out;
    out.dof = calibrator_->rows_of(use, terms_of(candidates, calibrator_->theta()), eliminator_.get());
    out.n_theta = calibrator_->theta().columns();
    out.n_candidates = static_cast<int>(candidates.size());
    const core::PackedTriangle<double> T = calibrator_->theta_triangle();
    out.triangle.assign(T.row(0), T.row(0) + core::packed_size(T.columns()));
    return out;
  }

  CoreSensorRows sensor_rows(std::uint32_t serial, const std::vector<CoreTerm>& candidates) override {
    for (const auto& s : segment_) {
      if (s->serial == serial) return sensor_rows_of(*s, calibrator_->theta(), model_, candidates);
    }
    throw InputError("this side has no segment " + std::to_string(serial));
  }

 private:
  void fit() {
    std::vector<core::Segment<double>*> pointers;
    for (const auto& s : segment_) pointers.push_back(s.get());
    calibrator_->begin(pointers.data(), static_cast<int>(pointers.size()), prior_, prior_.mean, model_);
    core::CalibratorOptions few;
    few.max_iterations = kIterations;
    calibrator_->accept_all();
    run(few);
    calibrator_->reject_outliers(kOutlierSigmas);
    run(few);
    chi2_per_dof_ = calibrator_->fit().chi2 / calibrator_->fit().dof;
  }

  void run(const core::CalibratorOptions& options) {
    do {
      ++work_;
    } while (!calibrator_->run_step(options, eliminator_.get()));
  }

  core::MeasurementModel<double> model_;
  core::ThetaPrior<double> prior_;
  std::vector<std::unique_ptr<core::Segment<double>>> segment_;
  std::unique_ptr<core::Calibrator<double>> calibrator_ = std::make_unique<core::Calibrator<double>>();
  std::unique_ptr<core::SegmentEliminator<double>> eliminator_ = std::make_unique<core::SegmentEliminator<double>>();
  std::vector<double> moved_;
  double chi2_per_dof_ = 0;
  std::int64_t work_ = 0;
};

}  // namespace

std::unique_ptr<CoreSide> side_of(const core::CDevice& device, const std::vector<std::uint32_t>& serials,
                                  const std::vector<double>& expected) {
  std::vector<const core::Segment<core::Real>*> segments;
  for (int slot = 0; slot <= SEGCAL_MAX_SEGMENTS; ++slot) {
    const core::Segment<core::Real>* s = core::find_slot(device, slot);
    if (s && std::count(serials.begin(), serials.end(), s->serial) > 0) segments.push_back(s);
  }
  if (segments.empty()) throw InputError("the core keeps none of these segments");
  return std::make_unique<Side>(device.device.options(), device.device.calibrator().theta(), segments, expected);
}

}  // namespace SEGCAL_NS
}  // namespace host
