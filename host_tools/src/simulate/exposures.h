// Exposure times that a camera's control chooses, and stamps that follow them.
#pragma once

#include "effect.h"

namespace host::sim {

/// The brightness of what a camera sees goes up and down over seconds, and its exposure with it: between 2 and 20 ms,
/// both of which it comes to, evenly in its logarithm as controls work. A sine whose phase another one pulls about, so
/// that no two of its periods are alike; drawn from the seed.
class AutoExposure {
 public:
  explicit AutoExposure(std::uint64_t seed);
  /// Of the image stamped t, s since the first frame; whole ns, as exposure.csv has them.
  double at(double t) const;

 private:
  double period_s_, pull_period_s_, phase_, pull_phase_;
};

/// Stamps are not of the middle of the exposure: t_middle = t_stamp + kappa exposure. 0.5: of its start, -0.5: its end.
class ExposureOffset : public Effect {
 public:
  explicit ExposureOffset(double kappa) : kappa_(kappa) {}
  EffectTruth truth() const override { return {"exposure_offset", {{"kappa", kappa_, "-"}}}; }
  double after_stamp(double exposure_s) const override { return kappa_ * exposure_s; }
  bool needs_exposures() const override { return true; }

 private:
  double kappa_;
};

}  // namespace host::sim
