// A camera that comes through the C API: checked, and in the core's type.
#pragma once

#include "api/accept_vectors.h"
#include "segcal/segcal.h"
#include "sensors/calibration.h"

namespace SEGCAL_NS {

/// False where a value is out of the range that segcal.h states. Static:
/// where it is called once it becomes part of its caller, at no cost.
static bool camera_from_c(const segcal_camera_t& in, CameraCalibration<SEGCAL_REAL>* out) {
  using Real = SEGCAL_REAL;
  constexpr double kMostMetres = 100, kMostPixel = 1e5, kMostDistortion = 100, kMostFocal = 1e5;
  if (in.model < SEGCAL_FOV || in.model > SEGCAL_EQUIDISTANT) return false;
  out->model = static_cast<Distortion>(in.model);
  if (!accept_vector<3>(in.p_CI, -kMostMetres, kMostMetres, &out->p_CI)) return false;
  if (!accept(in.intrinsics, 2, 1, kMostFocal, &out->intrinsics(0))) return false;
  if (!accept(in.intrinsics + 2, 2, -kMostPixel, kMostPixel, &out->intrinsics(2))) return false;
  if (!accept_vector<4>(in.distortion, -kMostDistortion, kMostDistortion, &out->distortion)) return false;
  if (in.model == SEGCAL_FOV && !(in.distortion[0] >= 0 && in.distortion[0] <= 2.5)) return false;
  if (in.height < -100000 || in.height > 100000) return false;
  out->middle_line = in.height != 0 ? Real(0.5 * in.height) : out->intrinsics(3);
  if (in.height == 0 && !(out->middle_line > Real(0))) out->middle_line = Real(1);
  return accept_rotation(in.q_CI, &out->R_CI);
}

}  // namespace SEGCAL_NS
