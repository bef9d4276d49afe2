// Some of the kept segments, calibrated by themselves.
//
// Where the calibration stepped in the middle of a recording, one theta for all segments is right for none of them, and
// rows that are linearised at it miss what is curved: of 28 mrad between camera and IMU some per cent.
#pragma once

#include "replay/core.h"

namespace host {

class CoreSide {
 public:
  virtual ~CoreSide() = default;
  /// theta here less the last calibration's, per column (terms of effects behind the calibration's).
  virtual const std::vector<double>& moved() const = 0;
  virtual double chi2_per_dof() const = 0;  ///< of its fit
  virtual std::int64_t work() const = 0;    ///< that the fit took, in slices (Core::work)
  /// As Core's, of these segments, at their own theta.
  virtual CoreRows linearise(const std::vector<std::uint32_t>& serials, const std::vector<CoreTerm>& candidates) = 0;
  virtual CoreSensorRows sensor_rows(std::uint32_t serial, const std::vector<CoreTerm>& candidates) = 0;
};

}  // namespace host
