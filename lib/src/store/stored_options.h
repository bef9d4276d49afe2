// What a device must have in common with the one that stored its memory: capacities, layout and configuration, field by
// field (docs/storage.md, "Records").
#pragma once

#include "api/capacities.h"
#include "api/device.h"
#include "store/fields.h"

namespace SEGCAL_NS {

template <class S>
struct StoredOptions {
  /// The numbers of a calibration; what cameras and terms it has is the configuration's.
  static void calibration(Fields* f, Calibration<S>* theta) {
    for (int c = 0; c < theta->n_cameras; ++c) {
      f->matrix(&theta->camera[c].R_CI);
      f->matrix(&theta->camera[c].p_CI);
      f->matrix(&theta->camera[c].intrinsics);
      f->matrix(&theta->camera[c].distortion);
    }
    ImuCalibration<S>& imu = theta->imu;
    for (Vec3<S>* v : {&imu.gyro_scale, &imu.gyro_misalignment, &imu.accel_scale, &imu.accel_misalignment})
      f->matrix(v);
    f->matrix(&imu.R_AI);
    f->array(theta->effects.value, theta->effects.count());
  }

  /// What must be the same for stored numbers to mean the same.
  static void identity(Fields* f, DeviceOptions<S>* o) {
    f->name("capacities", SEGCAL_ERROR_CAPACITY);
    for (int i = 0; i < SEGCAL_N_CAPACITIES; ++i) {
      std::uint32_t capacity = kCapacities[i];
      if (i == kEffectColumnsCapacity) {
        f->remark(capacity);
      } else {
        f->number(&capacity);
      }
    }
    std::uint32_t layout[] = {sizeof(S), sizeof(Observation), sizeof(FaultCounts), sizeof(BuilderCounts),
                              sizeof(MeasurementModel<S>)};
    f->name("layout of the library's numbers", SEGCAL_ERROR_CAPACITY);
    f->array(layout, 5);
    cameras(f, &o->prior.mean);
    const int n = o->prior.mean.columns();
    f->name("prior_sigma");
    f->array(o->prior.sigma, n);
    f->name("sigma_ref");
    f->array(o->sigma_ref, n);
    f->name("trigger_sigma");
    f->array(o->target_sigma, n);
    model(f, &o->model);
    f->name("imu_rate_hz");
    f->number(&o->imu_rate_hz);
    f->name("imu_rate_hz or segment_s");
    f->number(&o->imu_group);
    f->name("gyro_range");
    f->number(&o->gyro_range);
    f->name("accel_range");
    f->number(&o->accel_range);
    policy(f, o);
  }

 private:
  static void cameras(Fields* f, Calibration<S>* mean) {
    f->name("n_cameras");
    f->number(&mean->n_cameras);
    f->name("camera");
    for (int c = 0; c < mean->n_cameras; ++c) {
      f->choice(&mean->camera[c].model, 3);
      f->number(&mean->camera[c].middle_line);
    }
    f->name("term");
    f->number(&mean->effects.n);
    f->records(mean->effects.term, mean->effects.count(), sizeof(Term));
    f->name("starting calibration");
    calibration(f, mean);
  }
  static void model(Fields* f, MeasurementModel<S>* m) {
    f->name("noise of the IMU");
    for (S* v : {&m->imu.gyro, &m->imu.gyro_walk, &m->imu.accel, &m->imu.accel_walk}) f->number(v);
    f->name("pixel_sigma");
    f->number(&m->pixel_sigma);
    f->name("track_walk");
    f->number(&m->track_walk);
    f->name("gravity");
    f->matrix(&m->g);
    f->name("measurement model");
    for (S* v : {&m->bias_a_sigma, &m->bias_g_sigma, &m->velocity_sigma, &m->inverse_depth_sigma,
                 &m->turned_inverse_depth_sigma, &m->huber}) {
      f->number(v);
    }
  }
  static void policy(Fields* f, DeviceOptions<S>* o) {
    f->name("frame_interval_s");
    f->number(&o->frame_interval_s);
    f->name("segment_s");
    for (S* v : {&o->segment_s, &o->least_segment_s, &o->most_segment_s}) f->number(v);
    f->name("filter_share");
    f->number(&o->filter_share);
    f->name("keep_segments");
    f->number(&o->keep_segments);
    f->name("metric");
    f->choice(&o->metric, 5);
    f->name("strategy");
    f->choice(&o->strategy, 2);
    f->name("least_gain_nats");
    f->number(&o->least_gain);
    f->name("seed");
    f->number(&o->seed);
    f->name("outdated_level");
    f->number(&o->outdated_level);
    f->name("has_temperature");
    f->flag(&o->has_temperature);
  }
};

}  // namespace SEGCAL_NS
