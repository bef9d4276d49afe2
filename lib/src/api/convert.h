// Between the C API's plain structs and the core's types; checks of a configuration.
#pragma once

#include "api/device.h"
#include "segcal/segcal.h"

namespace SEGCAL_NS {

using Real = SEGCAL_REAL;

[[gnu::cold]] bool options_from_config(const segcal_config_t& config, DeviceOptions<Real>* out);
[[gnu::cold]] void parameter_names(const Calibration<Real>& theta, segcal_parameter_t* out);
/// Values of theta as results print them: rotations as the rotation vectors nearest to those of `mean`, the prior's.
void parameter_values(const Calibration<Real>& mean, const Calibration<Real>& theta, double* out);
/// False for a term that the core does not know.
bool term_from_c(const segcal_term_t& in, Term* out);
segcal_term_t term_to_c(const Term& term);
/// Name, unit and prior sigma.
[[gnu::cold]] void describe(const Term& term, segcal_parameter_t* out);
void camera_to_c(const CameraCalibration<Real>& camera, segcal_camera_t* out);
void imu_to_c(const ImuCalibration<Real>& imu, segcal_imu_calibration_t* out);
/// `origin`: what the state's place counts from, m.
void state_to_c(const State<Real>& state, const double* origin, std::int64_t t_ns, segcal_state_t* out);
/// All but the place, which stays double; false for numbers out of their range.
bool state_from_c(const segcal_state_t& in, State<Real>* out);

}  // namespace SEGCAL_NS
