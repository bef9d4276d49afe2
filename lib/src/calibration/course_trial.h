// The courses of theta (course.h) compared, in slices.
#pragma once

#include "calibration/course.h"
#include "calibration/prior.h"
#include "information/marginal.h"
#include "math/near.h"
#include "math/resumable.h"

namespace SEGCAL_NS {

template <class S>
class CourseTrial {
 public:
  static constexpr int kScratch = packed_size(2 * kMaxTheta + 1) + packed_size(kMaxTheta + 1) + 2 * kMaxTheta;

  /// `scratch`: kScratch numbers.
  void begin(S* scratch) {
    place_ = inner_ = 0;
    scratch_ = scratch;
  }
  /// `item(i)`: a CourseItem, i < count. `theta`: that all are moved to. `noise_scale`: of sigmas over those of stated
  /// noise. In slices; true when `out` is whole.
  template <class Items>
  [[gnu::cold]] bool step(const Items& item, int count, const ThetaPrior<S>& prior, const Calibration<S>& theta,
                          S noise_scale, bool has_temperature, Course<S>* out) {
    SEGCAL_SLICES(place_) {
      *out = Course<S>{};
      measure(item, count, theta, has_temperature);
      out->sessions = sessions_;
      SEGCAL_PAUSE(place_);
      for (form_ = 0; sessions_ >= kLeastSessions && form_ < kCourseForms; ++form_) {
        if (form_ == temperature_form && !(range_ >= S(kLeastRange))) continue;
        // Of steps, each session that may be the first after one.
        for (at_ = form_ == steps_form ? 0 : count - 1; at_ < count; ++at_) {
          if (form_ == steps_form && (levels_ > 2 || !begins_session(item, at_, first_))) continue;
          step_session_ = item(at_).session;
          begin_triangle(prior, theta, 2 * theta.columns());
          SEGCAL_AWAIT(place_, fold_step(item, count, theta, S(1) / noise_scale, 2 * theta.columns()));
          take_courses(prior, theta, out);
          SEGCAL_PAUSE(place_);
        }
      }
      for (level_ = 0; sessions_ >= kLeastSessions && levels_ > 1 && level_ < levels_; ++level_) {
        if (!has_level(item, count, first_level_ + level_)) continue;
        begin_triangle(prior, theta, theta.columns());
        SEGCAL_AWAIT(place_, fold_step(item, count, theta, S(1) / noise_scale, theta.columns()));
        take_level(prior, theta.columns());
        SEGCAL_PAUSE(place_);
      }
      decide(out);
    }
    SEGCAL_SLICES_END(place_);
  }

 private:
  static constexpr int kRowsAtOnce = 8;
  static constexpr S kNotAsked = S(-1);  ///< of a cost, which is never below 0: columns are in the prior's sigmas

  /// Over m columns and the rhs.
  PackedTriangle<S> triangle(int m) { return PackedTriangle<S>(scratch_, m + 1); }
  S span() const { return form_ == steps_form ? S(1) : form_ == trend_form ? last_ - first_ : range_; }
  S place_of(const CourseItem<S>& item) const {
    if (form_ == steps_form) return item.session < step_session_ ? S(-1) : S(0);
    return (form_ == trend_form ? item.session - last_ : item.warmth - at_end_) / span();
  }

  template <class Items>
  void measure(const Items& item, int count, const Calibration<S>& theta, bool has_temperature) {
    for (S& cost : cost_) cost = kNotAsked;
    constant_ = decided_ = best_ = kNotAsked;
    sessions_ = blocks_ = 0;
    for (int c = 0; c < theta.columns(); c = end_of_block(theta, c)) ++blocks_;
    S least = S(0), most = S(0);
    std::int32_t last_level = 0;
    for (int i = 0; i < count; ++i) {
      const CourseItem<S> one = item(i);
      bool another = true;
      for (int k = 0; k < i; ++k) another = another && item(k).session != one.session;
      sessions_ += another ? 1 : 0;
      if (i == 0 || one.session >= last_) at_end_ = one.warmth;
      if (i == 0 || one.session < first_) first_ = one.session;
      if (i == 0 || one.session > last_) last_ = one.session;
      if (i == 0 || one.warmth < least) least = one.warmth;
      if (i == 0 || one.warmth > most) most = one.warmth;
      if (i == 0 || one.changes < first_level_) first_level_ = one.changes;
      if (i == 0 || one.changes > last_level) last_level = one.changes;
    }
    levels_ = last_level - first_level_ + 1;
    range_ = has_temperature ? most - least : S(0);
    coldest_ = least;
  }

  /// The prior of theta, and of v where there are more than n columns.
  void begin_triangle(const ThetaPrior<S>& prior, const Calibration<S>& theta, int m) {
    const int n = theta.columns();
    PackedTriangle<S> T = triangle(m);
    write_prior(prior, theta, &T);
    for (int i = n; i < m; ++i) T.row(i)[i] = S(1) / prior.sigma[i - n];
  }
  /// All items; of a level, where there is no v.
  template <class Items>
  bool fold_step(const Items& item, int count, const Calibration<S>& theta, S weight, int m) {
    SEGCAL_SLICES(inner_) {
      for (i_ = 0; i_ < count; ++i_) {
        if (m == theta.columns() && item(i_).changes != first_level_ + level_) continue;
        for (row_ = 0; row_ < theta.columns(); row_ += kRowsAtOnce) {
          fold(item(i_), theta, weight, m);
          SEGCAL_PAUSE(inner_);
        }
      }
    }
    SEGCAL_SLICES_END(inner_);
  }
  /// kRowsAtOnce rows from row_ on.
  void fold(const CourseItem<S>& item, const Calibration<S>& theta, S weight, int m) {
    const int n = theta.columns();
    PackedTriangle<S> T = triangle(m);
    S offset[kMaxTheta], row[2 * kMaxTheta + 1];
    difference(*item.theta, theta, offset);
    const S x = place_of(item);
    for (int i = row_; i < n && i < row_ + kRowsAtOnce; ++i) {
      moved_row(*item.rows, offset, i, row);
      row[m] = row[n] * weight;
      for (int c = 0; c < n; ++c) {
        row[c] *= weight;
        if (m > n) row[n + c] = x * row[c];
      }
      fold_rows(T, row, 1, m + 1, i, m + 1);
    }
  }
  /// 2 ln of the first n diagonal entries in the prior's sigmas.
  S occam(const PackedTriangle<S>& T, const S* sigma, int n) const {
    S sum = S(0);
    for (int i = 0; i < n; ++i) sum += S(2) * logarithm(absolute(T(i, i)) * sigma[i]);
    return sum;
  }
  void take_level(const ThetaPrior<S>& prior, int n) {
    const PackedTriangle<S> T = triangle(n);
    decided_ = (decided_ < S(0) ? S(0) : decided_) + T(n, n) * T(n, n) + occam(T, prior.sigma, n);
  }

  /// v of each block alone; after two changes, of all of theta, since levels are of all of it.
  void take_courses(const ThetaPrior<S>& prior, const Calibration<S>& theta, Course<S>* out) {
    const int n = theta.columns();
    const PackedTriangle<S> T = triangle(2 * n);
    constant_ = occam(T, prior.sigma, n);
    for (int j = n; j <= 2 * n; ++j) constant_ += T(j, 2 * n) * T(j, 2 * n);
    if (levels_ > 2) return take_block(prior, n, 0, n, out);
    for (int c = 0; c < n; c = end_of_block(theta, c)) take_block(prior, n, c, end_of_block(theta, c) - c, out);
  }
  /// v of `count` columns from `first` on. The rows of theta are triangular already; those below are folded without the
  /// columns that are zero.
  void take_block(const ThetaPrior<S>& prior, int n, int first, int count, Course<S>* out) {
    const PackedTriangle<S> T = triangle(2 * n);
    PackedTriangle<S> V(scratch_ + packed_size(2 * n + 1), count + 1);
    V.clear();
    S row[kMaxTheta + 1];
    for (int j = n; j <= 2 * n; ++j) {
      for (int c = 0; c < count; ++c) row[c] = n + first + c < j ? S(0) : T(j, n + first + c);
      row[count] = T(j, 2 * n);
      fold_rows(V, row, 1, count + 1, 0, count + 1);
    }
    const S tries = S(count < n ? blocks_ : 1) * (form_ == steps_form ? S(sessions_ - 1) : S(1));
    const S cost = V(count, count) * V(count, count) + occam(T, prior.sigma, n) + occam(V, prior.sigma + first, count) +
                   S(2) * logarithm(tries);
    if (!is_finite(cost)) return;
    if (cost_[form_] == kNotAsked || cost < cost_[form_]) cost_[form_] = cost;
    const bool best = best_ == kNotAsked || cost < best_,
               close = best_ != kNotAsked && cost < best_ + S(2 * kToldApart);
    if (!best && !close) return;
    // Which block it is may not be told: a camera that turns is one whose centre moves. The lag is the largest of any.
    S v[kMaxTheta];
    hold_lag(V, n, first, count, close && cost > best_ - S(2 * kToldApart), v, out);
    if (!best) return;
    best_ = cost;
    for (int i = 0; i < n; ++i) out->rate[i] = out->sigma[i] = S(0);
    const S one = S(1);
    S work[kMaxTheta + 1];
    for (int c = 0; c < count; ++c) {
      out->rate[first + c] = v[c] / span();
      out->sigma[first + c] = marginal_sigma(V, count, c, &one, 1, work) / span();
    }
    out->rate_form = likeliest_ = form_;
    out->step_session = form_ == steps_form ? static_cast<std::uint32_t>(step_session_) : 0;
  }
  /// How far theta is from what it is now; beside others, the larger one. `v`: the block's.
  void hold_lag(const PackedTriangle<S>& V, int n, int first, int count, bool beside, S* v, Course<S>* out) {
    const PackedTriangle<S> T = triangle(2 * n);
    S now[kMaxTheta];
    for (int c = 0; c < count; ++c) v[c] = V(c, count);
    back_substitute(V, count, v);
    for (int i = 0; i < n; ++i) {
      now[i] = T(i, 2 * n);
      for (int c = 0; c < count; ++c) now[i] -= T(i, n + first + c) * v[c];
    }
    back_substitute(T, n, now);
    for (int i = 0; i < n; ++i) {
      const S of_v = i >= first && i < first + count ? v[i - first] / span() : S(0), one = lag(now[i], of_v);
      if (!beside || one > out->lag[i]) out->lag[i] = one;
    }
  }
  /// `now`: at the last item. With temperature, the farther one of the two ends of the range.
  S lag(S now, S rate) const {
    if (form_ != temperature_form) return absolute(now);
    const S cold = absolute(now + (coldest_ - at_end_) * rate);
    const S warm = absolute(now + (coldest_ + range_ - at_end_) * rate);
    return cold > warm ? cold : warm;
  }

  /// What the odds rule out; and whether theta was a constant, or what the decided changes made it.
  void decide(Course<S>* out) {
    if (sessions_ < kLeastSessions || best_ == kNotAsked || !is_finite(constant_)) return;
    const bool as_decided = levels_ == 1 && constant_ < best_ + S(2 * kFalseCourse);
    if (as_decided) cost_[steps_form] = constant_;
    if (levels_ > 1 && (cost_[steps_form] == kNotAsked || decided_ < cost_[steps_form])) cost_[steps_form] = decided_;
    S least = cost_[steps_form];
    for (int f = 1; f < kCourseForms; ++f) {
      if (cost_[f] != kNotAsked && cost_[f] < least) least = cost_[f];
    }
    for (int f = 0; f < kCourseForms; ++f) {
      out->ln_odds[f] = cost_[f] != kNotAsked ? (least - cost_[f]) / S(2) : S(1);
      if (cost_[f] != kNotAsked && out->ln_odds[f] > S(-kToldApart)) out->forms |= 1u << f;
    }
    if (as_decided) out->forms = 1u << steps_form;
    // Sigmas need no proof: what is likelier than a constant, or than the decided changes, counts.
    const bool likelier = levels_ == 1 ? best_ < constant_ : best_ < decided_ && likeliest_ != steps_form;
    if (as_decided || !likelier) out->rate_form = -1;
    for (int i = 0; i < kMaxTheta && !likelier; ++i) out->lag[i] = S(0);
  }

  Near<S> scratch_;
  Place place_ = 0, inner_ = 0;
  std::int32_t form_ = 0, likeliest_ = 0, at_ = 0, level_ = 0, i_ = 0, row_ = 0;
  std::int32_t sessions_ = 0, blocks_ = 0, first_level_ = 0, levels_ = 0;
  S first_ = S(0), last_ = S(0), range_ = S(0), at_end_ = S(0), coldest_ = S(0), step_session_ = S(0);
  S cost_[kCourseForms] = {}, constant_ = S(0), decided_ = S(0), best_ = S(0);  ///< -2 ln p
};

}  // namespace SEGCAL_NS
