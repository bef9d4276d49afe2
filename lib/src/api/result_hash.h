// One number over the bits of everything that a device found out: two builds or two machines that agree in it have
// computed the same, operation by operation.
#pragma once

#include "api/release.h"
#include "calibration/epochs.h"
#include "database/database.h"
#include "math/hash.h"

namespace SEGCAL_NS {

template <class S>
[[gnu::cold]] void add_to_hash(const State<S>& x, Hash* hash) {
  hash->add(x.R_GI.data(), 9);
  for (const Vec3<S>* v : {&x.p_GI, &x.v_GI, &x.b_a, &x.b_g}) hash->add(v->data(), 3);
}

template <class S>
[[gnu::cold]] void add_to_hash(const Calibration<S>& theta, Hash* hash) {
  hash->add(std::int32_t(theta.n_cameras));
  for (int c = 0; c < theta.n_cameras; ++c) {
    const CameraCalibration<S>& camera = theta.camera[c];
    hash->add(camera.R_CI.data(), 9);
    hash->add(camera.p_CI.data(), 3);
    hash->add(camera.intrinsics.data(), 4);
    hash->add(camera.distortion.data(), 4);
  }
  const ImuCalibration<S>& imu = theta.imu;
  for (const Vec3<S>* v : {&imu.gyro_scale, &imu.gyro_misalignment, &imu.accel_scale, &imu.accel_misalignment}) {
    hash->add(v->data(), 3);
  }
  hash->add(imu.R_AI.data(), 9);
  for (int i = 0; i < theta.effects.n; ++i) {
    const Term& t = theta.effects.term[i];
    hash->add(std::uint32_t(t.kind) << 24 | std::uint32_t(t.a) << 16 | std::uint32_t(t.b) << 8 | t.c);
    hash->add(theta.effects.value[i]);
  }
}

template <class S>
[[gnu::cold]] void add_to_hash(const Release<S>& release, Hash* hash) {
  hash->add(static_cast<std::int32_t>(release.status));
  hash->add(release.noise_scale);
  hash->add(release.sigma, release.theta.columns());
  for (int i = 0; i < release.theta.columns(); ++i) hash->add(static_cast<std::int32_t>(release.verdict[i]));
}

/// What was measured and what became of it.
template <class S>
[[gnu::cold]] void add_to_hash(const Segment<S>& s, Hash* hash) {
  hash->add(s.t0_ns);
  for (std::uint32_t number : {s.serial, s.session, s.frame}) hash->add(number);
  hash->add(s.t_us, s.n_keyframes);
  for (int k = 0; k < s.n_keyframes; ++k) add_to_hash(s.states.x[k], hash);
  hash->add(s.track_id, s.n_landmarks);
  for (int j = 0; j < s.n_landmarks; ++j) {
    const Landmark<S>& l = s.states.landmark[j];
    hash->add(l.o.data(), 3);
    hash->add(l.m.data(), 3);
    hash->add(l.rho);
  }
  for (int o = 0; o < s.n_observations; ++o) {
    const Observation& z = s.observation[o];
    hash->add(z.u);
    hash->add(z.v);
    hash->add(std::uint32_t(z.landmark) << 16 | std::uint32_t(z.keyframe) << 8 | std::uint32_t(z.camera) << 1 |
              z.rejected);
  }
  for (int i = 0; i < s.imu.size(); ++i) {
    const InertialReading<S> reading = s.imu.reading(i);
    hash->add(s.imu.time(i));
    hash->add(reading.gyro.data(), 3);
    hash->add(reading.accel.data(), 3);
  }
  const int n = s.information.n_theta + 1;
  hash->add(s.information.data, n * (n + 1) / 2);
  hash->add(s.metrics.A);
  hash->add(s.metrics.D);
  hash->add(s.metrics.E);
}

/// What condensed segments said.
template <class S>
[[gnu::cold]] void add_to_hash(const Epochs<S>& epochs, Hash* hash) {
  for (int i = 0; i < epochs.count(); ++i) {
    const Epoch<S>& e = epochs.epoch(i);
    hash->add(e.segments);
    hash->add(e.information.data, packed_size(e.columns() + 1));
  }
}
template <class S>
[[gnu::cold]] void add_to_hash(const NoEpochs<S>&, Hash*) {}

/// The kept segments in their order in time: in which slot one stands does not matter.
template <class S>
[[gnu::cold]] void add_to_hash(const Database<S>& database, Hash* hash) {
  bool done[Database<S>::kSlots] = {};
  for (int left = database.size(); left > 0; --left) {
    int next = -1;
    for (int i = 0; i < Database<S>::kSlots; ++i) {
      if (!database.kept(i) || done[i]) continue;
      if (next < 0 || database.slot(i).serial < database.slot(next).serial) next = i;
    }
    done[next] = true;
    add_to_hash(database.slot(next), hash);
  }
}

}  // namespace SEGCAL_NS
