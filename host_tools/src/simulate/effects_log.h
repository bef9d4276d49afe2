// Faults of electronics and loggers as effects of the simulator: each is one disturbance of the finished log.
#pragma once

#include <functional>

#include "disturb.h"
#include "effect.h"

namespace host::sim {

class LogFault : public Effect {
 public:
  using Disturbance = std::function<void(Recording&, std::uint64_t seed)>;
  LogFault(EffectTruth truth, Disturbance disturbance)
      : truth_(std::move(truth)), disturbance_(std::move(disturbance)) {}
  EffectTruth truth() const override { return truth_; }
  void on_log(Recording& recording, std::uint64_t seed) const override { disturbance_(recording, seed); }

 private:
  EffectTruth truth_;
  Disturbance disturbance_;
};

}  // namespace host::sim
