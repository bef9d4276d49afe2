// What of a device outlives power, field by field (docs/storage.md, "Records").
#pragma once

#include "api/device.h"
#include "store/stored_history.h"
#include "store/stored_numbers.h"
#include "store/stored_options.h"

namespace SEGCAL_NS {

template <class S>
struct StoredFields {
  static_assert(sizeof(State<S>) == 21 * sizeof(S) && sizeof(Landmark<S>) == 7 * sizeof(S),
                "stored as arrays of numbers");
  static_assert(kMaxKeyframes * kMaxCameras <= 64, "one bit for each image of a segment");

  /// theta and the last report; before the first calibration the report is that of create().
  static void results(Fields* f, Device<S>* d) {
    StoredOptions<S>::calibration(f, &d->theta_);
    f->number(&d->theta_.effects.time_zero_ns);
    const int n = d->prior().mean.columns();
    Release<S>& r = d->jobs_.report_.release;
    CalibrationReport<S>& report = d->jobs_.report_;
    f->choice(&r.status, 3);
    StoredOptions<S>::calibration(f, &r.theta);
    f->array(r.sigma, n);
    f->array(r.printed_sigma, n);
    for (int i = 0; i < n; ++i) f->choice(&r.verdict[i], 3);
    f->number(&r.noise_scale);
    StoredOptions<S>::calibration(f, &report.theta);
    CalibrationFit<S>& fit = report.fit;
    f->flag(&fit.converged);
    for (std::int32_t* v : {&fit.iterations, &fit.image_points, &report.segments, &report.partitions}) f->number(v);
    for (S* v :
         {&fit.start_cost, &fit.cost, &fit.chi2, &fit.dof, &report.reprojection.rms, &report.reprojection.median})
      f->number(v);
    f->count(&report.directions.n, n);
    f->array(report.directions.s, report.directions.n);
    f->array(report.directions.V, report.directions.n * report.directions.n);
  }

  static void segment(Fields* f, Segment<S>* s) {
    f->number(&s->t0_ns);
    f->array(s->origin, 3);
    for (std::uint32_t* v : {&s->serial, &s->session, &s->frame}) f->number(v);
    f->count(&s->n_keyframes, kMaxKeyframes);
    f->count(&s->n_landmarks, kMaxLandmarks);
    f->count(&s->n_observations, kMaxObservations);
    f->number(&s->lead_us);
    f->number(&s->stamp_shift_ns);
    f->flag(&s->turned_only);
    f->flag(&s->wide_depth_prior);
    ImuStore<S>& imu = s->imu;
    f->count(&imu.count_, SEGCAL_MAX_IMU_SAMPLES);
    f->number(&imu.newest_us_);
    f->number(&imu.gyro_step_);
    f->number(&imu.accel_step_);
    f->count(&s->information.n_theta, kMaxTheta);
    f->number(&s->information.dof);
    for (S* v : {&s->metrics.A, &s->metrics.D, &s->metrics.E, &s->metrics.gain}) f->number(v);
    f->number(&s->metrics.rank);
    f->array(s->t_us, s->n_keyframes);
    f->array(s->warmth, s->n_keyframes);
    f->array(s->track_id, s->n_landmarks);
    f->records(s->states.x, s->n_keyframes, sizeof(State<S>));
    f->records(s->states.landmark, s->n_landmarks, sizeof(Landmark<S>));
    f->array(s->information.data, packed_size(s->information.n_theta + 1));
    f->array(imu.anchor_us_, (imu.count_ + kStampsPerAnchor - 1) / kStampsPerAnchor);
    f->records(s->observation, s->n_observations, sizeof(Observation));
    f->array(s->first_observation, s->n_landmarks + 1);
    f->array(imu.delta_us_, imu.count_);
    f->array(&imu.value_[0][0], 6 * imu.count_);
  }
  /// Whether they never go back, which loops over samples rely on; and far from where sums would overflow.
  static bool stamps_grow(const ImuStore<S>& imu) {
    constexpr std::int32_t kMost = 1 << 30;
    for (int i = 0; i < imu.count_; ++i) {
      const std::int32_t anchor = imu.anchor_us_[i / kStampsPerAnchor];
      if (anchor > kMost || anchor < -kMost || (i > 0 && imu.time(i) < imu.time(i - 1))) return false;
    }
    return true;
  }

  /// Whether all that others use as an index is one. What the CRC
  /// lets through was written by this library, unless by intent.
  static bool sound(const Segment<S>& s, const Calibration<S>& theta) {
    if (s.n_keyframes < 2 || s.information.n_theta != theta.columns() || s.first_observation[0] != 0) return false;
    if (s.first_observation[s.n_landmarks] != s.n_observations || s.imu.count_ < 2) return false;
    if (!stamps_grow(s.imu)) return false;
    for (int k = 1; k < s.n_keyframes; ++k) {
      if (s.t_us[k] <= s.t_us[k - 1]) return false;
    }
    for (int j = 0; j < s.n_landmarks; ++j) {
      if (s.first_observation[j + 1] <= s.first_observation[j] || s.first_observation[j + 1] > s.n_observations)
        return false;
      std::uint64_t images = 0;
      for (int o = s.first_observation[j]; o < s.first_observation[j + 1]; ++o) {
        const Observation& z = s.observation[o];
        if (z.landmark != static_cast<unsigned>(j) || z.keyframe >= s.n_keyframes || z.camera >= theta.n_cameras)
          return false;
        const std::uint64_t image = std::uint64_t(1) << (z.keyframe * kMaxCameras + z.camera);
        if ((images & image) != 0) return false;
        images |= image;
      }
    }
    return true;
  }

  /// Whether segments go into epochs, and how many of those there are.
  static void memory(Fields* f, Device<S>* d) {
    f->flag(&d->jobs_.condensing_);
    f->flag(&d->jobs_.new_epoch_);
    f->number(&d->jobs_.misfits_);
  }
  /// What dates changes and says when to calibrate again. Of a build without epochs there is none.
  static void changes(Fields* f, Device<S>* d) {
    if constexpr (kEpochs > 0) {
      f->number(&d->jobs_.made_from_);
      f->number(&d->jobs_.open_segments_);
      Changes<S>& c = d->d_.changes;
      f->flag(&c.is_open_);
      f->count(&c.count_, kChanges);
      change(f, &c.open_);
      for (Change<S>& one : c.change_) change(f, &one);
    }
  }
  static void change(Fields* f, Change<S>* c) {
    for (std::uint32_t* v : {&c->before_session, &c->after_session}) f->number(v);
    f->number(&c->t_ns);
    f->count(&c->n, kMaxTheta);
    f->array(c->step, kMaxTheta);
    f->array(c->sigma, kMaxTheta);
  }
  static void epoch(Fields* f, Device<S>* d, int index) {
    if constexpr (kEpochs > 0) {
      Epoch<S>& e = d->d_.epochs.epoch_[index];
      for (std::int32_t* v : {&e.segments, &e.image_points}) f->number(v);
      for (std::uint32_t* v : {&e.first_session, &e.last_session, &e.last_serial}) f->number(v);
      for (S* v : {&e.pulls.found, &e.pulls.expected, &e.dof}) f->number(v);
      StoredOptions<S>::calibration(f, &e.theta);
      f->number(&e.theta.effects.time_zero_ns);
      f->count(&e.information.n_theta, kMaxTheta);
      f->array(e.information.data, packed_size(e.information.n_theta + 1));
    }
  }
  static void history(Fields* f, Device<S>* d) { StoredHistory<S>::all(f, &d->d_.history, &d->jobs_.report_.course); }
  static void session(Fields* f, Device<S>* d, int i) { StoredHistory<S>::session(f, &d->d_.history, i); }
  /// Before an epoch's fields are taken: cameras and terms are the configuration's.
  static void begin_epoch(Device<S>* d, int index) {
    if constexpr (kEpochs > 0) d->d_.epochs.epoch_[index].theta = d->theta_;
  }
  static void begin_session(Device<S>* d, int i) { StoredHistory<S>::begin(&d->d_.history, i, d->theta_); }
  static bool keep_session(Device<S>* d, int i) { return StoredHistory<S>::sound(d->d_.history, i, d->theta_); }
  static bool keep_epoch(Device<S>* d, int index) {
    if constexpr (kEpochs > 0) {
      const Epoch<S>& e = d->d_.epochs.epoch_[index];
      d->d_.epochs.count_ = index + 1;
      return e.information.n_theta == d->theta_.columns() && e.segments >= 0;  // the newest may have just begun
    }
    return false;
  }

  // What the fields above do not reach: where they come from, and where they go.
  static bool at_rest(const Device<S>& d) { return d.jobs_.finished_ && !d.pending(); }
  static bool untouched(const Device<S>& d) {
    return d.d_.faults.imu_samples == 0 && d.d_.faults.frames == 0 && d.session_ == 0 && d.d_.database().size() == 0;
  }
  static DeviceOptions<S>* options(Device<S>* d) { return &d->d_.options; }
  static Segment<S>* slot(Device<S>* d, int i) { return &d->d_.database().slot_[i]; }
  static void keep(Device<S>* d, int i) { d->d_.database().kept_[i] = true; }

  /// Changes when anything is done that moves what a save reads.
  static std::uint64_t revision(const Device<S>& d) {
    return std::uint64_t(d.session_) << 40 ^ std::uint64_t(d.d_.faults.segments_closed) << 20 ^
           d.d_.faults.calibrations;
  }

  static StoredNumbers<S> take_numbers(const Device<S>& d) {
    StoredNumbers<S> n{};
    n.faults = d.d_.faults;
    n.left_out = d.d_.builder.counts_;
    n.trajectory = d.odometry_.trajectory.value();
    n.random = d.d_.database().random_;
    n.offered = d.d_.database().offered_;
    n.frame_period = d.frames_.period_ns;
    for (int i = 0; i < 3; ++i) n.builder_origin[i] = d.d_.builder.origin_[i];
    n.session = d.session_;
    n.serial = d.serial_;
    n.frame = d.odometry_.frame;
    n.building = d.d_.database().building_;
    n.warmth = d.imu_.history.warmth();
    n.knew_enough = d.jobs_.knew_enough_;
    n.own_odometry = d.odometry_.own;
    n.calibrated = d.jobs_.calibrated_;
    n.session_open = d.imu_.any || d.frames_.any;
    return n;
  }

  /// Before fields are taken: the device as created, whose results have the cameras and terms of the configuration.
  static void begin(Device<S>* d) {
    const bool at_once = d->at_once_;  // no data: who calls the device decides it
    d->create(d->d_.options, d->d_.cold);
    d->work_when_due(at_once);
    d->jobs_.report_ = CalibrationReport<S>{};
    d->jobs_.report_.theta = d->jobs_.report_.release.theta = d->theta_;
    for (Verdict& v : d->jobs_.report_.release.verdict) v = Verdict::fixed;
    d->jobs_.report_.directions.n = 0;
  }

  /// Puts all that was taken in force, as segcal_new_session does at its end.
  static bool install(const StoredNumbers<S>& n, Device<S>* d) {
    Database<S>& database = d->d_.database();
    if (database.kept_[n.building] || database.size() > database.capacity_) return false;
    d->d_.faults = n.faults;
    d->d_.builder.counts_ = n.left_out;
    d->odometry_.trajectory = Hash(n.trajectory);
    database.random_ = n.random;
    database.offered_ = n.offered;
    database.building_ = n.building;
    d->frames_.period_ns =
        n.frame_period >= kShortestPeriodNs && n.frame_period <= kLongestPauseNs ? n.frame_period : 0;  // 0: not known
    for (int i = 0; i < 3; ++i) d->d_.builder.origin_[i] = n.builder_origin[i];
    d->session_ = n.session;
    d->serial_ = n.serial;
    d->odometry_.frame = n.frame;
    d->imu_.history.set_warmth(n.warmth);
    d->jobs_.knew_enough_ = n.knew_enough;
    d->odometry_.own = n.own_odometry;
    d->jobs_.calibrated_ = n.calibrated;
    d->jobs_.condensing_ = d->jobs_.condensing_ && d->d_.options.condense;  // who restores may have switched it off
    if (!d->d_.options.condense) d->d_.changes.close();
    if (d->d_.epochs.count() == 0) d->jobs_.new_epoch_ = true;  // format 1.1's are passed over
    const std::int64_t zero = d->theta_.effects.time_zero_ns;
    d->d_.options.prior.mean.effects.time_zero_ns = d->jobs_.report_.theta.effects.time_zero_ns = zero;
    d->jobs_.report_.release.theta.effects.time_zero_ns = zero;
    d->d_.calibrator().theta_ = d->jobs_.report_.theta;  // where kept segments were fitted
    d->stamp_shift_ns_ = Device<S>::stamp_shift(d->theta_);
    d->d_.monitor.reset(d->prior(), d->theta_);
    if (n.session_open) {
      d->begin_session();
    } else {
      if (!n.own_odometry) --d->odometry_.frame;  // counted already when the session began
      d->restart_filter();
    }
    return true;
  }
};

}  // namespace SEGCAL_NS
