// How did theta change over sessions: not at all but for the changes that were decided, steadily with time, or with
// temperature?
//
// Item i (a session, or a kept segment) says |R_i (theta_i [-] theta) - d_i|^2 about the calibration theta_i that the
// device had then. Three courses of theta_i, all of Gaussian entries with the prior's sigmas, so that a change may be
// as large as devices differ:
//   steps        one theta for all items between two changes, each drawn anew from the prior
//   trend        theta + x_i v, x_i from -1 in the first session to 0 in the last
//   temperature  theta + x_i v, x_i the item's temperature over the range of all
// The evidence of each follows from the triangle R of prior and items, whose columns are in the prior's sigmas:
//   -2 ln p = rho^2 + 2 sum_j ln |R_jj| + what is the same for all
// (misfit and Occam factor: MacKay, Bayesian interpolation, Neural Computation 4, 1992, section 2). Courses whose odds
// against the likeliest are better than 1 in 20 are not told apart.
//
// Where no change was decided, steps are no change at all, and what is slow may be far smaller than devices differ: a
// constant is ruled out by what a trend, or temperature, explains of its misfit, as a change is (contradiction.h). What
// was released is a mean over sessions then, and says how far it is from what it should be.
#pragma once

#include "calibration/contradiction.h"
#include "calibration/history.h"
#include "calibration/prior.h"
#include "information/marginal.h"
#include "math/near.h"
#include "math/resumable.h"

namespace SEGCAL_NS {

enum CourseForm : std::int32_t { steps_form, trend_form, temperature_form, kCourseForms };

/// ln 20: a course that is less likely than the best by more is out.
constexpr double kToldApart = 3;
/// Probability that noise rules a constant out, as it finds a change (kFalseChange).
constexpr double kFalseCourse = 1e-4;
/// Two sessions are a line whatever the device does.
constexpr int kLeastSessions = 3;
/// degC between the items, at least: an IMU's own heat, and how far it is from the camera's, are a few in each session.
constexpr double kLeastRange = 5;

template <class S>
struct Course {
  std::uint32_t forms = 0;                        ///< bit form: not ruled out; 0: fewer than three sessions
  std::int32_t sessions = 0;                      ///< that took part
  S ln_odds[kCourseForms] = {};                   ///< against the likeliest; 1: not compared
  std::int32_t rate_form = 0;                     ///< the likelier one of trend and temperature
  S rate[kMaxTheta] = {}, sigma[kMaxTheta] = {};  ///< of theta's columns, per session or degC
  /// Where steps are ruled out: from theta to what it is now, or at the temperature that is farthest from it.
  S lag[kMaxTheta] = {};
};

/// Of a build without a history.
struct NoCourse {};

template <class S>
struct CourseItem {
  const SegmentInformation<S>* rows;
  const Calibration<S>* theta;  ///< where they are linearised
  S session, warmth;            ///< degC above 25
  std::int32_t changes;         ///< decided before it
};

template <class S>
class CourseTrial {
 public:
  static constexpr int kScratch = packed_size(2 * kMaxTheta + 1) + 2 * kMaxTheta;

  /// `scratch`: kScratch numbers.
  void begin(S* scratch) {
    place_ = 0;
    scratch_ = scratch;
  }
  /// `item(i)`: a CourseItem, i < count. `theta`: that all are moved to. `noise_scale`: of sigmas over those of stated
  /// noise. In slices; true when `out` is whole.
  template <class Items>
  [[gnu::cold]] bool step(const Items& item, int count, const ThetaPrior<S>& prior, const Calibration<S>& theta,
                          S noise_scale, bool has_temperature, Course<S>* out) {
    SEGCAL_SLICES(place_) {
      *out = Course<S>{};
      measure(item, count, has_temperature);
      out->sessions = sessions_;
      SEGCAL_PAUSE(place_);
      for (form_ = 0; sessions_ >= kLeastSessions && form_ < kCourseForms; ++form_) {
        if (form_ == temperature_form && !(range_ >= S(kLeastRange))) continue;
        for (level_ = first_level_; level_ <= (form_ == steps_form ? last_level_ : first_level_); ++level_) {
          begin_triangle(prior, theta);
          for (i_ = 0; i_ < count; ++i_) {
            if (form_ == steps_form && item(i_).changes != level_) continue;
            for (row_ = 0; row_ < theta.columns(); row_ += kRowsAtOnce) {
              fold(item(i_), theta, S(1) / noise_scale);
              SEGCAL_PAUSE(place_);
            }
          }
          take_cost(prior, theta);
          SEGCAL_PAUSE(place_);
        }
        if (form_ == steps_form || (out->rate_form > 0 && cost_[form_] > cost_[out->rate_form])) continue;
        out->rate_form = form_;
        for (i_ = 0; i_ < theta.columns(); ++i_) {
          read_rate(i_, theta.columns(), out);
          SEGCAL_PAUSE(place_);
        }
      }
      decide(theta.columns(), noise_scale, out);
    }
    SEGCAL_SLICES_END(place_);
  }

 private:
  static constexpr int kRowsAtOnce = 8;

  /// Over m columns and the rhs.
  PackedTriangle<S> triangle(int m) { return PackedTriangle<S>(scratch_, m + 1); }

  /// Of the columns of the form at hand.
  int width(int n) const { return form_ == steps_form ? n : 2 * n; }
  S span() const { return form_ == trend_form ? last_ - first_ : range_; }

  template <class Items>
  void measure(const Items& item, int count, bool has_temperature) {
    for (int f = 0; f < kCourseForms; ++f) cost_[f] = misfit_[f] = S(-1);
    sessions_ = 0;
    items_ = count;
    S least = S(0), most = S(0);
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
      if (i == 0 || one.changes > last_level_) last_level_ = one.changes;
    }
    range_ = has_temperature ? most - least : S(0);
    coldest_ = least;
  }

  /// The prior of theta, and of v.
  void begin_triangle(const ThetaPrior<S>& prior, const Calibration<S>& theta) {
    const int n = theta.columns(), m = width(n);
    PackedTriangle<S> T = triangle(m);
    write_prior(prior, theta, &T);
    for (int i = n; i < m; ++i) T.row(i)[i] = S(1) / prior.sigma[i - n];
    if (misfit_[form_] < S(0)) cost_[form_] = misfit_[form_] = S(0);
  }
  /// kRowsAtOnce rows from row_ on.
  void fold(const CourseItem<S>& item, const Calibration<S>& theta, S weight) {
    const int n = theta.columns(), m = width(n);
    PackedTriangle<S> T = triangle(m);
    S offset[kMaxTheta], row[2 * kMaxTheta + 1];
    difference(*item.theta, theta, offset);
    const S x =
        form_ == steps_form ? S(0) : (form_ == trend_form ? item.session - last_ : item.warmth - at_end_) / span();
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
  void take_cost(const ThetaPrior<S>& prior, const Calibration<S>& theta) {
    const int n = theta.columns(), m = width(n);
    const PackedTriangle<S> T = triangle(m);
    const S square = T(m, m) * T(m, m);
    misfit_[form_] += square;
    cost_[form_] += square;
    for (int i = 0; i < m; ++i) cost_[form_] += S(2) * logarithm(absolute(T(i, i)) * prior.sigma[i < n ? i : i - n]);
  }
  /// Of column i, from the triangle over [theta | v].
  void read_rate(int i, int n, Course<S>* out) {
    PackedTriangle<S> T = triangle(2 * n);
    S* x = T.row(0) + packed_size(2 * n + 1);
    if (i == 0) {
      for (int k = 0; k < 2 * n; ++k) x[k] = T(k, 2 * n);
      back_substitute(T, 2 * n, x);
      for (int k = 0; k < n; ++k) {
        out->rate[k] = x[n + k] / span();
        out->lag[k] = lag(x[k], out->rate[k]);
      }
    }
    const S one = S(1);
    out->sigma[i] = marginal_sigma(T, 2 * n, n + i, &one, 1, x) / span();
  }
  /// `now`: at the last item. With temperature, the farther one of the two ends of the range.
  S lag(S now, S rate) const {
    if (form_ == trend_form) return now;
    const S cold = now + (coldest_ - at_end_) * rate, warm = cold + range_ * rate;
    return absolute(cold) > absolute(warm) ? cold : warm;
  }
  /// Of n columns. The excess of misfit over noise is in few directions of each sensor (spread.h).
  bool explains(int form, int n, S noise_scale) const {
    if (misfit_[form] < S(0)) return false;
    Spread<S> spread;
    spread.add(noise_scale * noise_scale * S(n * items_), n * items_);
    return misfit_[steps_form] - misfit_[form] > spread.uneven_limit(n, S(kFalseCourse), kSensors) * S(n);
  }
  /// Courses that are compared, and what their odds rule out.
  void decide(int n, S noise_scale, Course<S>* out) const {
    if (sessions_ < kLeastSessions) return;
    bool compared[kCourseForms];
    for (int f = 0; f < kCourseForms; ++f) compared[f] = misfit_[f] >= S(0);
    if (first_level_ == last_level_) {
      for (int f = trend_form; f < kCourseForms; ++f) compared[f] = explains(f, n, noise_scale);
      compared[steps_form] = !compared[trend_form] && !compared[temperature_form];
    }
    int best = -1;
    for (int f = 0; f < kCourseForms; ++f) {
      if (compared[f] && (best < 0 || cost_[f] < cost_[best])) best = f;
    }
    for (int f = 0; f < kCourseForms; ++f) {
      out->ln_odds[f] = compared[f] ? (cost_[best] - cost_[f]) / S(2) : S(1);
      if (compared[f] && out->ln_odds[f] > S(-kToldApart)) out->forms |= 1u << f;
    }
    if ((out->forms & 1u << steps_form) == 0) return;
    for (S& lag : out->lag) lag = S(0);
  }

  Near<S> scratch_;
  Place place_ = 0;
  std::int32_t form_ = 0, level_ = 0, i_ = 0, row_ = 0;
  std::int32_t items_ = 0, sessions_ = 0, first_level_ = 0, last_level_ = 0;
  S first_ = S(0), last_ = S(0), range_ = S(0), at_end_ = S(0);
  S coldest_ = S(0);
  S cost_[kCourseForms] = {}, misfit_[kCourseForms] = {};  ///< misfit: below 0 where not asked
};

}  // namespace SEGCAL_NS
