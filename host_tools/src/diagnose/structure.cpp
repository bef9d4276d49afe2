#include "diagnose/structure.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "diagnose/chi_square.h"

namespace host::diagnosis {
namespace {

constexpr int kBins = 8;
constexpr std::size_t kFewest = 80;  ///< ten per bin
constexpr int kPieces = 16;          ///< of time: a few seconds each, longer than a corner is seen

std::vector<int> order_of(const std::vector<double>& x) {
  std::vector<int> order(x.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&x](int a, int b) { return x[a] < x[b]; });
  return order;
}

std::vector<double> ranks_of(const std::vector<double>& x, const std::vector<int>& order) {
  std::vector<double> rank(x.size());
  for (std::size_t from = 0, to = 0; from < order.size(); from = to) {
    while (to < order.size() && x[order[to]] == x[order[from]]) ++to;
    for (std::size_t i = from; i < to; ++i) rank[order[i]] = 0.5 * static_cast<double>(from + to - 1);
  }
  return rank;
}

double correlation(const std::vector<double>& a, const std::vector<double>& b) {
  const double n = static_cast<double>(a.size());
  const double ma = std::accumulate(a.begin(), a.end(), 0.0) / n, mb = std::accumulate(b.begin(), b.end(), 0.0) / n;
  double ab = 0, aa = 0, bb = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    ab += (a[i] - ma) * (b[i] - mb);
    aa += (a[i] - ma) * (a[i] - ma);
    bb += (b[i] - mb) * (b[i] - mb);
  }
  return aa > 0 && bb > 0 ? ab / std::sqrt(aa * bb) : 0;
}

/// Means per bin and the sum of squares between bins.
double between_bins(const std::vector<double>& value, const std::vector<double>& cause, const std::vector<int>& order,
                    double variance, Structure* out) {
  double sum = 0;
  for (int b = 0; b < kBins; ++b) {
    const std::size_t from = order.size() * b / kBins, to = order.size() * (b + 1) / kBins;
    double mean = 0, at = 0;
    for (std::size_t i = from; i < to; ++i) {
      mean += value[order[i]];
      at += cause[order[i]];
    }
    const double n = static_cast<double>(to - from);
    mean /= n;
    out->bin_cause.push_back(at / n);
    out->bin_mean.push_back(mean);
    out->bin_sigma.push_back(std::sqrt(variance / n));
    sum += n * mean * mean;
  }
  return sum;
}

/// By how much the slope of value over cause scatters beyond what independent residuals give, as a variance, at least
/// 1: cluster-robust (Liang and Zeger, "Longitudinal data analysis using generalized linear models", Biometrika 73,
/// 1986), the clusters being pieces of time. Points of one image share the error of its stamp, and corners drift for
/// seconds.
double design_effect(const std::vector<int>& in_time, std::vector<double> value, std::vector<double> cause) {
  if (in_time.empty()) return 1;
  const auto centre = [](std::vector<double>* x) {
    const double mean = std::accumulate(x->begin(), x->end(), 0.0) / static_cast<double>(x->size());
    for (double& a : *x) a -= mean;
  };
  centre(&value);
  centre(&cause);
  const double xx = std::inner_product(cause.begin(), cause.end(), cause.begin(), 0.0);
  const double xv = std::inner_product(cause.begin(), cause.end(), value.begin(), 0.0);
  const double vv = std::inner_product(value.begin(), value.end(), value.begin(), 0.0);
  if (!(xx > 0 && vv > 0)) return 1;
  double sum = 0;
  for (int b = 0; b < kPieces; ++b) {
    double score = 0;
    for (std::size_t i = in_time.size() * b / kPieces; i < in_time.size() * (b + 1) / kPieces; ++i)
      score += cause[in_time[i]] * (value[in_time[i]] - xv / xx * cause[in_time[i]]);
    sum += score * score;
  }
  const double independent = xx * vv / static_cast<double>(value.size());
  return std::max(1.0, kPieces / (kPieces - 1.0) * sum / independent);
}

/// `in_time`: the order of the residuals' times; `shrink`: effective over actual number of residuals, by how they
/// follow each other along their series.
Structure hold_against(const ResidualList& list, Cause cause, const std::vector<double>& value_rank,
                       const std::vector<int>& in_time, double shrink) {
  const std::vector<double>& x = list.cause[static_cast<int>(cause)];
  const double n = static_cast<double>(list.value.size());
  const double mean = std::accumulate(list.value.begin(), list.value.end(), 0.0) / n;
  std::vector<double> centred = list.value;
  double variance = 0;
  for (double& v : centred) {
    v -= mean;
    variance += v * v / n;
  }
  Structure out{list.sensor, list.axis, words_of(cause), unit_of(cause), 0, 0, {}, {}, {}};
  const std::vector<int> order = order_of(x);
  const std::vector<double> cause_rank = ranks_of(x, order);
  const double between = between_bins(centred, x, order, variance, &out), rho = correlation(value_rank, cause_rank);
  shrink = std::min(shrink, 1 / design_effect(in_time, value_rank, cause_rank));
  const double p_rank = log10_upper_tail(rho * rho * n * shrink, 1),
               p_bins = log10_upper_tail(between / variance * shrink, kBins - 1);
  out.correlation = p_rank <= p_bins ? rho : std::sqrt(between / (variance * n));
  out.log10_p = std::min(p_rank, p_bins);
  return out;
}

bool varies(const std::vector<double>& x) {
  return !x.empty() && *std::max_element(x.begin(), x.end()) > *std::min_element(x.begin(), x.end());
}

}  // namespace

double lag_one_autocorrelation(const ResidualList& list) {
  double product = 0, square = 0;
  for (std::size_t i = 1; i < list.value.size(); ++i) {
    if (list.series[i] != list.series[i - 1]) continue;
    product += list.value[i] * list.value[i - 1];
    square += 0.5 * (list.value[i] * list.value[i] + list.value[i - 1] * list.value[i - 1]);
  }
  return square > 0 ? product / square : 0;
}

std::vector<Structure> find_structure(const std::vector<ResidualList>& lists, double level, int most) {
  std::vector<Structure> out;
  int tests = 0;
  for (const ResidualList& list : lists) {
    if (list.value.size() < kFewest) continue;
    const double a = std::max(0.0, lag_one_autocorrelation(list)), shrink = (1 - a) / (1 + a);
    const std::vector<double> value_rank = ranks_of(list.value, order_of(list.value));
    const std::vector<int> in_time = order_of(list.cause[static_cast<int>(Cause::time)]);
    std::vector<Structure> found;
    for (int c = 0; c < kCauses; ++c) {
      if (!varies(list.cause[c])) continue;
      tests += 2;
      found.push_back(hold_against(list, static_cast<Cause>(c), value_rank, in_time, shrink));
    }
    std::sort(found.begin(), found.end(), [](const Structure& x, const Structure& y) { return x.log10_p < y.log10_p; });
    if (static_cast<int>(found.size()) > most) found.resize(most);
    out.insert(out.end(), found.begin(), found.end());
  }
  for (Structure& s : out) s.log10_p += std::log10(std::max(1, tests));
  out.erase(std::remove_if(out.begin(), out.end(), [level](const Structure& s) { return s.log10_p >= level; }),
            out.end());
  std::sort(out.begin(), out.end(), [](const Structure& x, const Structure& y) { return x.log10_p < y.log10_p; });
  return out;
}

}  // namespace host::diagnosis
