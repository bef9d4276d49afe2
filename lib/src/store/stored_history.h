// Records of what sessions said and of the course that theta took (calibration/course.h).
#pragma once

#include "api/report.h"
#include "store/stored_options.h"

namespace SEGCAL_NS {

template <class S>
struct StoredHistory {
  /// How many sessions are remembered, changes among them, and what the last calibration found.
  static void all(Fields* f, History<S>* h, Course<S>* c) {
    f->count(&h->count_, kHistory);
    f->count(&h->changes_, 1 << 20);
    f->number(&c->forms);
    f->number(&c->sessions);
    f->array(c->ln_odds, kCourseForms);
    f->number(&c->rate_form);
    f->number(&c->step_session);
    f->array(c->rate, kMaxTheta);
    f->array(c->sigma, kMaxTheta);
    f->array(c->lag, kMaxTheta);
  }
  static void session(Fields* f, History<S>* h, int i) {
    HistoryEntry<S>& e = h->entry_[i];
    for (std::int32_t* v : {&e.segments, &e.changes}) f->number(v);
    f->number(&e.session);
    f->number(&e.warmth);
    StoredOptions<S>::calibration(f, &e.theta);
    f->number(&e.theta.effects.time_zero_ns);
    f->count(&e.information.n_theta, kMaxTheta);
    f->array(e.information.data, packed_size(e.information.n_theta + 1));
  }
  /// Before a session's fields are taken: cameras and terms are the configuration's.
  static void begin(History<S>* h, int i, const Calibration<S>& theta) { h->entry_[i].theta = theta; }
  static bool sound(const History<S>& h, int i, const Calibration<S>& theta) {
    const HistoryEntry<S>& e = h.entry_[i];
    return e.information.n_theta == theta.columns() && e.segments >= 0 && e.changes >= 0 && e.changes <= h.changes_;
  }

  // A build without a history.
  static void all(Fields*, NoHistory<S>*, NoCourse*) {}
  static void session(Fields*, NoHistory<S>*, int) {}
  static void begin(NoHistory<S>*, int, const Calibration<S>&) {}
  static bool sound(const NoHistory<S>&, int, const Calibration<S>&) { return false; }
};

}  // namespace SEGCAL_NS
