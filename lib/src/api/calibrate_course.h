// CalibrateJob: how theta changed over the sessions that are remembered (calibration/course.h).
#pragma once

#include "api/calibrate_job.h"

namespace SEGCAL_NS {

/// Of a calibration that is released; where it decides a change, with that.
template <class S>
[[gnu::cold]] bool CalibrateJob<S>::judge_course_step(DeviceParts<S>* d) {
  if constexpr (kHistory > 0) {
    const auto item = [this, d](int i) { return course_item(i, *d); };
    SEGCAL_SLICES(inner_) {
      course_ = Course<S>{};
      if (work_.release()->status == Status::calibrated && d->options.condense) {
        if (changed_) d->history.take_change(d->changes.open()->before_session);
        trial_.begin(work_.template numbers<CourseTrial<S>::kScratch>());
        SEGCAL_PAUSE(inner_);
        SEGCAL_AWAIT(inner_, trial_.step(item, d->history.count() + n_, d->prior(), d->calibrator().theta(),
                                         work_.release()->noise_scale, d->options.has_temperature, &course_));
        hold_lag(d->prior());
      }
    }
    SEGCAL_SLICES_END(inner_);
  }
  return true;
}

/// A mean over sessions in which theta was not one: sigmas hold what it is now, or was at some temperature.
template <class S>
void CalibrateJob<S>::hold_lag(const ThetaPrior<S>& prior) {
  if constexpr (kHistory > 0) {
    Release<S>* r = work_.release();
    const auto hold = [](S sigma, S lag, S most) {
      const S both = square_root(sigma * sigma + lag * lag);
      return both < most ? both : most;
    };
    for (int i = 0; i < r->theta.columns(); ++i) {
      const PrintedValue<S> value = printed_value(prior.mean, r->theta, i);
      const S lag = printed_lag(course_, value);
      r->sigma[i] = hold(r->sigma[i], course_.lag[i], prior.sigma[i]);
      const S before = sigma_before(value, prior.sigma);
      r->printed_sigma[i] = hold(r->printed_sigma[i], lag, before);
      if (r->verdict[i] == Verdict::observed && !(r->printed_sigma[i] < ReleaseRules<S>{}.observed * before))
        r->verdict[i] = Verdict::weak;
    }
  }
}

/// What was condensed, then the kept segments.
template <class S>
CourseItem<S> CalibrateJob<S>::course_item(int i, const DeviceParts<S>& d) const {
  if (const HistoryEntry<S>* e = d.history.find(i))
    return {&e->information, &e->theta, S(e->session), e->mean_warmth(), e->changes};
  const Segment<S>& s = *segment_[i - d.history.count()];
  return {&s.information, &d.calibrator().theta(), S(s.session), mean_warmth(s), d.history.changes()};
}

}  // namespace SEGCAL_NS
