#include "stamps/smooth_stamps.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "quantile.h"

namespace host {
namespace {

constexpr double half_window_s = 1;  // 30 images: a line that is good to a fifth of one stamp's jitter
constexpr double envelope_s = 0.15;  // longer than a callback is ever late
constexpr double lag_s = 0.3;        // six times as long as a late callback holds up others
constexpr std::size_t least_envelope = 5;
/// Where one image of ten is missing, most slopes over `lag_s` span a hole, and the period by them is a tenth too long.
/// So it is looked for between these shares of it, by how much the stamps agree on their phase: 1 if they are even, 0.8
/// with delays of an eighth of the period; what agrees by less than half has a period by slopes only.
constexpr double shortest_share = 0.6, longest_share = 1.05, least_agreement = 0.5;
constexpr double as_good = 0.03;  ///< slopes that are no further off lead to the right numbers
constexpr int reweightings = 6;

/// A stream of stamps in s from the first one, with the number of each event.
class SmoothedStream {
 public:
  explicit SmoothedStream(const std::vector<std::int64_t>& t_ns) {
    for (const std::int64_t t : t_ns) t_.push_back(1e-9 * static_cast<double>(t - t_ns.front()));
    for (std::size_t i = 0; i < t_.size(); ++i) n_.push_back(static_cast<double>(i));
    number();
    const std::vector<double> even = coherent_periods();
    if (std::all_of(even.begin(), even.end(), [](double period) { return period == 0; })) return;
    number(&even);
    number();
  }

  /// The line's value at event i, minus the stamp; s.
  double correction(std::size_t i) const {
    const auto begin = std::lower_bound(t_.begin(), t_.end(), t_[i] - half_window_s) - t_.begin();
    const auto end = std::upper_bound(t_.begin(), t_.end(), t_[i] + half_window_s) - t_.begin();
    std::vector<double> x, y, off;
    for (auto j = static_cast<std::size_t>(begin); j < static_cast<std::size_t>(end); ++j) {
      x.push_back(n_[j] - n_[i]);
      y.push_back(t_[j] - t_[i]);
    }
    if (x.size() < least_envelope) return 0;
    double a = 0, b = local_period(i), scale = std::numeric_limits<double>::infinity();
    for (int round = 0; round < reweightings; ++round) {
      double w0 = 0, wx = 0, wy = 0, wxx = 0, wxy = 0;
      for (std::size_t k = 0; k < x.size(); ++k) {
        const double r = (y[k] - a - b * x[k]) / scale, w = 1 / (1 + r * r);
        w0 += w;
        wx += w * x[k];
        wy += w * y[k];
        wxx += w * x[k] * x[k];
        wxy += w * x[k] * y[k];
      }
      b = (w0 * wxy - wx * wy) / (w0 * wxx - wx * wx);
      a = (wy - b * wx) / w0;
      off.clear();
      for (std::size_t k = 0; k < x.size(); ++k) off.push_back(std::abs(y[k] - a - b * x[k]));
      scale = std::max(2 * middle_of(off), 1e-6);
    }
    return a;
  }

  double missing() const { return n_.back() - static_cast<double>(n_.size() - 1); }

 private:
  /// Median slope over `lag_s` by the numbers so far, of the events within half a window. A late callback that
  /// holds up those behind it shortens many single intervals, but hardly any of these slopes.
  double local_period(std::size_t i) const {
    std::size_t begin = i, end = i;
    while (begin > 0 && t_[i] - t_[begin - 1] < half_window_s) --begin;
    while (end + 1 < t_.size() && t_[end + 1] - t_[i] < half_window_s) ++end;
    std::size_t lag = 1;
    while (begin + lag < end && t_[begin + lag] - t_[begin] < lag_s) ++lag;
    std::vector<double> slopes;
    for (std::size_t j = begin; j + lag <= end; ++j) slopes.push_back((t_[j + lag] - t_[j]) / (n_[j + lag] - n_[j]));
    return slopes.empty() ? 0 : middle_of(std::move(slopes));
  }

  /// Earliest stamp, less its number's share, of events from
  /// `first` on for `envelope_s`; numbers as if none was missing.
  double phase_after(std::size_t first, double number, double period) const {
    double earliest = std::numeric_limits<double>::infinity();
    for (std::size_t j = first; j < t_.size() && (j < first + least_envelope || t_[j] < t_[first] + envelope_s); ++j) {
      earliest = std::min(earliest, t_[j] - period * (number + static_cast<double>(j - first)));
    }
    return earliest;
  }
  double phase_before(std::size_t last, double period, const std::vector<double>& n) const {
    double earliest = std::numeric_limits<double>::infinity();
    for (std::size_t j = last + 1; j-- > 0 && (j + least_envelope > last || t_[j] > t_[last] - envelope_s);) {
      earliest = std::min(earliest, t_[j] - period * n[j]);
    }
    return earliest;
  }

  /// The period in which the stamps of two seconds agree most on their phase, for each event; 0 where they do not, or
  /// where slopes tell the same.
  std::vector<double> coherent_periods() const {
    std::vector<double> out(t_.size(), 0);
    for (std::size_t i = 0; i < t_.size();) {
      const double period = coherent_period(i), until = t_[i] + half_window_s / 2;
      while (i < t_.size() && t_[i] <= until) out[i++] = period;
    }
    return out;
  }
  double coherent_period(std::size_t i) const {
    const auto begin = std::lower_bound(t_.begin(), t_.end(), t_[i] - half_window_s),
               end = std::upper_bound(t_.begin(), t_.end(), t_[i] + half_window_s);
    const double rough = local_period(i), step = 0.1 / half_window_s;
    double best = least_agreement * static_cast<double>(end - begin), period = 0;
    for (double f = 1 / (longest_share * rough); f < 1 / (shortest_share * rough); f += step) {
      double c = 0, s = 0;
      for (auto t = begin; t != end; ++t) {
        c += std::cos(2 * M_PI * f * *t);
        s += std::sin(2 * M_PI * f * *t);
      }
      if (std::hypot(c, s) <= best) continue;
      best = std::hypot(c, s);
      period = 1 / f;
    }
    return std::abs(period - rough) > as_good * rough ? period : 0;
  }

  /// Anew, by the period that the numbers so far tell (local_period), or by these.
  void number(const std::vector<double>* periods = nullptr) {
    std::vector<double> n = {0};
    for (std::size_t i = 1; i < t_.size(); ++i) {
      double next = n.back() + 1;
      const double period = periods && (*periods)[i] > 0 ? (*periods)[i] : local_period(i);
      // Intervals that are nearly even need no second look.
      if (period > 0 && t_[i] - t_[i - 1] > 1.3 * period) {
        next += std::max(0.0, std::round((phase_after(i, next, period) - phase_before(i - 1, period, n)) / period));
      }
      n.push_back(next);
    }
    n_ = std::move(n);
  }

  std::vector<double> t_, n_;
};

}  // namespace

SmoothedStamps smooth_stamps(const std::vector<std::int64_t>& t_ns) {
  SmoothedStamps out{t_ns, 0, 0, 0, 0};
  const bool increasing =
      std::adjacent_find(t_ns.begin(), t_ns.end(), std::greater_equal<std::int64_t>()) == t_ns.end();
  if (t_ns.size() < 2 * least_envelope || !increasing) return out;
  const SmoothedStream stream(t_ns);
  std::vector<double> intervals;
  double squares = 0;
  for (std::size_t i = 0; i < t_ns.size(); ++i) {
    const double moved = stream.correction(i);
    out.t_ns[i] = t_ns[i] + static_cast<std::int64_t>(std::llround(1e9 * moved));
    if (i > 0) out.t_ns[i] = std::max(out.t_ns[i], out.t_ns[i - 1] + 1);
    if (i > 0) intervals.push_back(1e-9 * static_cast<double>(t_ns[i] - t_ns[i - 1]));
    squares += moved * moved;
    out.moved_most_s = std::max(out.moved_most_s, std::abs(moved));
  }
  out.period_s = middle_of(std::move(intervals));
  out.moved_rms_s = std::sqrt(squares / static_cast<double>(t_ns.size()));
  out.missing = static_cast<std::size_t>(stream.missing());
  return out;
}

}  // namespace host
