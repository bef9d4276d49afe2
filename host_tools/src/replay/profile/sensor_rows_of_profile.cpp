#include "replay/profile/sensor_rows_of_profile.h"

#include "api/handle.h"
#include "replay/profile/segment_in_double.h"
#include "replay/profile/segment_rows.h"

namespace host {
namespace SEGCAL_NS {

core::CandidateTerms terms_of(const std::vector<CoreTerm>& candidates, const core::Calibration<double>& theta) {
  if (static_cast<int>(candidates.size()) + theta.effects.count() > core::kMaxEffectColumns)
    throw InputError("the core does not linearise this many effects");
  core::CandidateTerms terms;
  for (const CoreTerm& t : candidates) {
    terms.term[terms.n++] = {static_cast<core::TermKind>(t.kind), static_cast<std::uint8_t>(t.a),
                             static_cast<std::uint8_t>(t.b), static_cast<std::uint8_t>(t.c)};
  }
  return terms;
}

CoreSensorRows sensor_rows_of(const core::Segment<double>& segment, const core::Calibration<double>& theta,
                              const core::MeasurementModel<double>& model, const std::vector<CoreTerm>& candidates) {
  const core::CandidateTerms terms = terms_of(candidates, theta);
  CoreSensorRows out = SegmentRows(segment, theta, model, terms).eliminated();
  out.n_theta = theta.columns();
  out.n_candidates = terms.n;
  return out;
}

CoreSensorRows sensor_rows_of(segcal_t* device, int slot, const std::vector<CoreTerm>& candidates) {
  const core::CDevice* d = core::open(device);
  const core::Segment<core::Real>* stored = d ? core::find_slot(*d, slot) : nullptr;
  if (!stored) throw InputError("the core keeps no segment in slot " + std::to_string(slot));
  const auto& options = d->device.options();
  return sensor_rows_of(*in_double(*stored, options.gyro_range, options.accel_range),
                        in_double(d->device.calibrator().theta()), in_double(options.model), candidates);
}

}  // namespace SEGCAL_NS
}  // namespace host
