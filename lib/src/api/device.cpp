// The one place where the device is instantiated: all other files of the C API see a declaration (handle.h), so that a
// build compiles filter, elimination and calibration once.
#include "api/handle.h"

namespace SEGCAL_NS {

template class Device<Real>;

}  // namespace SEGCAL_NS
