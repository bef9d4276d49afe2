#include "replay/profile/sensor_rows_of_profile.h"

#include "api/handle.h"
#include "replay/profile/segment_in_double.h"
#include "replay/profile/segment_rows.h"

namespace host {
namespace SEGCAL_NS {

CoreSensorRows sensor_rows_of(segcal_t* device, int slot, const std::vector<CoreTerm>& candidates) {
  const core::CDevice* d = core::open(device);
  const core::Segment<core::Real>* stored = d ? core::find_slot(*d, slot) : nullptr;
  const core::Calibration<double> theta = in_double(d->device.calibrator().theta());
  if (!stored || static_cast<int>(candidates.size()) + theta.effects.count() > core::kMaxEffectColumns) {
    throw InputError("the core does not linearise this segment and these effects");
  }
  core::CandidateTerms terms;
  for (const CoreTerm& t : candidates) {
    terms.term[terms.n++] = {static_cast<core::TermKind>(t.kind), static_cast<std::uint8_t>(t.a),
                             static_cast<std::uint8_t>(t.b), static_cast<std::uint8_t>(t.c)};
  }
  const auto& options = d->device.options();
  const std::unique_ptr<core::Segment<double>> segment = in_double(*stored, options.gyro_range, options.accel_range);
  const core::MeasurementModel<double> model = in_double(options.model);
  CoreSensorRows out = SegmentRows(*segment, theta, model, terms).eliminated();
  out.n_theta = theta.columns();
  out.n_candidates = terms.n;
  return out;
}

}  // namespace SEGCAL_NS
}  // namespace host
