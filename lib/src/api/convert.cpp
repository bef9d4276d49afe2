#include "api/convert.h"

#include "api/accept_vectors.h"

namespace SEGCAL_NS {

void parameter_names(const Calibration<Real>& theta, segcal_parameter_t* out) {
  const auto put = [&out](const char* group, int camera, const char* name, const char* unit) {
    char* p = out->name;
    for (const char* s = group; *s; ++s) *p++ = *s;
    if (camera >= 0) *p++ = static_cast<char>('0' + camera);
    *p++ = '.';
    for (const char* s = name; *s; ++s) *p++ = *s;
    *p = 0;
    char* u = out->unit;
    for (const char* s = unit; *s; ++s) *u++ = *s;
    *u = 0;
    ++out;
  };
  static const char* const kExtrinsic[6] = {"r_CI.x", "r_CI.y", "r_CI.z", "p_CI.x", "p_CI.y", "p_CI.z"};
  static const char* const kIntrinsic[4] = {"fx", "fy", "cx", "cy"};
  static const char* const kDistortion[3][4] = {{"w", "", "", ""}, {"k1", "k2", "p1", "p2"}, {"k1", "k2", "k3", "k4"}};
  for (int c = 0; c < theta.n_cameras; ++c) {
    const CameraCalibration<Real>& camera = theta.camera[c];
    for (int i = 0; i < 6; ++i) put("cam", c, kExtrinsic[i], i < 3 ? "rad" : "m");
    for (int i = 0; i < 4; ++i) put("cam", c, kIntrinsic[i], "px");
    for (int i = 0; i < camera.distortion_columns(); ++i) put("cam", c, kDistortion[int(camera.model)][i], "-");
  }
  static const char* const kImu[6] = {"sx", "sy", "sz", "mx", "my", "mz"};
  static const char* const kRotation[3] = {"r_AI.x", "r_AI.y", "r_AI.z"};
  for (int i = 0; i < 6; ++i) put("gyro", -1, kImu[i], "-");
  for (int i = 0; i < 6; ++i) put("accel", -1, kImu[i], "-");
  for (int i = 0; i < 3; ++i) put("accel", -1, kRotation[i], "rad");
  for (int i = 0; i < theta.effects.count(); ++i) describe(theta.effects.term[i], out++);
}

void parameter_values(const Calibration<Real>& mean, const Calibration<Real>& theta, double* out) {
  const auto put = [&out](const auto& v, int n) {
    for (int i = 0; i < n; ++i) *out++ = static_cast<double>(v(i));
  };
  for (int c = 0; c < theta.n_cameras; ++c) {
    const CameraCalibration<Real>& camera = theta.camera[c];
    put(printed_rotation(mean.camera[c].R_CI, camera.R_CI), 3);
    put(camera.p_CI, 3);
    put(camera.intrinsics, 4);
    put(camera.distortion, camera.distortion_columns());
  }
  put(theta.imu.gyro_scale, 3);
  put(theta.imu.gyro_misalignment, 3);
  put(theta.imu.accel_scale, 3);
  put(theta.imu.accel_misalignment, 3);
  put(printed_rotation(mean.imu.R_AI, theta.imu.R_AI), 3);
  for (int i = 0; i < theta.effects.count(); ++i) *out++ = static_cast<double>(theta.effects.value[i]);
}

void camera_to_c(const CameraCalibration<Real>& camera, segcal_camera_t* out) {
  out->model = static_cast<std::int32_t>(camera.model);
  const Vec<Real, 4> q = quaternion_from_matrix(camera.R_CI);
  for (int i = 0; i < 4; ++i) {
    out->q_CI[i] = static_cast<double>(q(i));
    out->intrinsics[i] = static_cast<double>(camera.intrinsics(i));
    out->distortion[i] = i < camera.distortion_columns() ? static_cast<double>(camera.distortion(i)) : 0;
  }
  out->height =
      static_cast<std::int32_t>(camera.middle_line * Real(2) + (camera.middle_line < Real(0) ? Real(-0.5) : Real(0.5)));
  for (int i = 0; i < 3; ++i) out->p_CI[i] = static_cast<double>(camera.p_CI(i));
}

void imu_to_c(const ImuCalibration<Real>& imu, segcal_imu_calibration_t* out) {
  const Vec<Real, 4> q = quaternion_from_matrix(imu.R_AI);
  for (int i = 0; i < 3; ++i) {
    out->gyro_scale[i] = static_cast<double>(imu.gyro_scale(i));
    out->gyro_misalignment[i] = static_cast<double>(imu.gyro_misalignment(i));
    out->accel_scale[i] = static_cast<double>(imu.accel_scale(i));
    out->accel_misalignment[i] = static_cast<double>(imu.accel_misalignment(i));
  }
  for (int i = 0; i < 4; ++i) out->q_AI[i] = static_cast<double>(q(i));
}

void state_to_c(const State<Real>& state, const double* origin, std::int64_t t_ns, segcal_state_t* out) {
  out->t_ns = t_ns;
  const Vec<Real, 4> q = quaternion_from_matrix(state.R_GI);
  for (int i = 0; i < 4; ++i) out->q_GI[i] = static_cast<double>(q(i));
  for (int i = 0; i < 3; ++i) {
    out->p_GI[i] = origin[i] + static_cast<double>(state.p_GI(i));
    out->v_GI[i] = static_cast<double>(state.v_GI(i));
    out->b_a[i] = static_cast<double>(state.b_a(i));
    out->b_g[i] = static_cast<double>(state.b_g(i));
  }
}

bool state_from_c(const segcal_state_t& in, State<Real>* out) {
  double p_GI[3];  // stays double: only its range is asked
  return accept(in.p_GI, 3, -1e9, 1e9, p_GI) && accept_vector<3>(in.v_GI, -1e4, 1e4, &out->v_GI) &&
         accept_vector<3>(in.b_a, -1e3, 1e3, &out->b_a) && accept_vector<3>(in.b_g, -1e2, 1e2, &out->b_g) &&
         accept_rotation(in.q_GI, &out->R_GI);
}

}  // namespace SEGCAL_NS
