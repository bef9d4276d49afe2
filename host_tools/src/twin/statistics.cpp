#include "twin/statistics.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "diagnose/hypotheses.h"
#include "diagnose/residuals.h"
#include "diagnose/structure.h"
#include "replay/track_residuals.h"

namespace host::twin {
namespace {

using diagnosis::Structure;

constexpr std::size_t kMostCauses = 4;
constexpr double kMostSquared = 1e4;  ///< a correlation is known to a hundredth of itself at best
constexpr double kAll = 1e9;          ///< log10 p: structure of every kind

/// Sums over the tracks of one segment: squares, and products of points `lag` keyframes apart.
struct TrackSums {
  double square = 0, count = 0, product = 0, square_of_pairs = 0;
};

TrackSums sums_of(const CoreKept& kept, const CoreModel& model, std::size_t lag) {
  TrackSums out;
  for (const auto& [key, track] : tracks_of_segment(kept)) {
    const std::vector<Eigen::Vector2d> r = residuals_px(track, model);
    for (std::size_t i = 0; i < r.size(); ++i) {
      out.square += 0.5 * r[i].squaredNorm();
      out.count += 1;
      if (i + lag >= r.size()) continue;
      out.product += r[i].dot(r[i + lag]);
      out.square_of_pairs += 0.5 * (r[i].squaredNorm() + r[i + lag].squaredNorm());
    }
  }
  return out;
}

TrackSums sum(const std::vector<TrackSums>& parts, std::size_t without) {
  TrackSums out;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (i == without) continue;
    out.square += parts[i].square;
    out.count += parts[i].count;
    out.product += parts[i].product;
    out.square_of_pairs += parts[i].square_of_pairs;
  }
  return out;
}

struct Figure {
  double value = 0, sigma = 0;
};

/// Of all segments, with the jackknife over them.
Figure over_segments(const ReplayResult& fit, std::size_t lag, const std::function<double(const TrackSums&)>& of) {
  std::vector<TrackSums> parts;
  for (const CoreKept& k : fit.kept) parts.push_back(sums_of(k, fit.model, lag));
  Figure out{of(sum(parts, parts.size())), 0};
  double mean = 0, square = 0;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const double one = of(sum(parts, i));
    mean += one / static_cast<double>(parts.size());
    square += one * one;
  }
  const auto n = static_cast<double>(parts.size());
  if (n > 1) out.sigma = std::sqrt(std::max(0.0, (square - n * mean * mean) * (n - 1) / n));
  return out;
}

double rms_px(const TrackSums& s) { return s.count > 0 ? std::sqrt(s.square / s.count) : 0; }
double autocorrelation(const TrackSums& s) { return s.square_of_pairs > 0 ? s.product / s.square_of_pairs : 0; }

/// Where motion fills the band it is an upper bound, and no figure: its sigma is zero.
Figure density(const SensorNoise& noise) {
  const bool told = noise.verdict != SensorNoise::Verdict::cannot_tell;
  return {noise.factor * noise.stated, told ? noise.sigma * noise.stated : 0};
}

/// The spread of noise alone, and what a large excess adds to it: of a chi-square of n degrees of freedom with the mean
/// n (1 + x) the variance is 2 n (1 + 2 x).
Figure excess(double x, double sigma, double dof) {
  return {x, std::sqrt(sigma * sigma + 4 * std::max(0.0, x) / std::max(1.0, dof))};
}

std::vector<Structure> structure_of(const Recording& session, const Diagnosis& d) {
  const ReplayResult& fit = d.fit_before;
  return find_structure(diagnosis::residual_lists(fit.kept, fit.model, fit.calibration, {session.imu}), kAll,
                        diagnosis::kCauses);
}

/// Without the sign: what is no straight line has none (diagnose/structure.h).
std::string words_of(const Structure& s) { return s.sensor + " " + s.axis + " follows " + s.against; }
double size_of(const Structure& s) { return std::abs(s.correlation); }

/// A correlation's own chance, from the probability that chance alone makes one as large: twice the logarithm of that
/// is the square of its sigmas.
double sigma_of(const Structure& s) {
  const double squared = std::min(-2 * std::log(10.0) * s.log10_p, kMostSquared);
  return squared > 1 ? size_of(s) / std::sqrt(squared) : size_of(s);
}

void add(const char* name, const char* unit, const Figure& f, std::vector<Statistic>* out) {
  out->push_back({name, unit, f.value, f.sigma, 0, 0});
}

/// A sensor's excess beyond that of its noise, which has figures of its own and counts in the gap where it has a name
/// (noise_effects.h): it is only named, and only counts, where the band is free of motion.
double beyond_noise(const Diagnosis& d, double excess, const char* sensor) {
  for (const DiagnosedEffect& e : d.effects) {
    if (diagnosis::hypothesis(e.name).kind != diagnosis::Kind::noise) continue;
    for (const DiagnosedParameter& p : e.parameters)
      if (p.name.rfind(sensor, 0) == 0) excess -= std::abs(p.value * p.value - 1);
  }
  return excess;
}

/// All but what residuals follow.
std::vector<Statistic> plain_statistics(const Diagnosis& d) {
  std::vector<Statistic> out;
  add("corners: residual with the plain model", "px", over_segments(d.fit_before, 1, rms_px), &out);
  add("corners: autocorrelation, next keyframe", "-", over_segments(d.fit_before, 1, autocorrelation), &out);
  add("corners: autocorrelation, fifth keyframe", "-", over_segments(d.fit_before, 5, autocorrelation), &out);
  add("excess of the camera", "-",
      excess(beyond_noise(d, d.before.camera, "pixel_noise"), d.gap_sigma.camera, d.gap_dof.camera), &out);
  add("excess of the gyroscope", "-",
      excess(beyond_noise(d, d.before.gyro, "gyro_noise"), d.gap_sigma.gyro, d.gap_dof.gyro), &out);
  add("excess of the accelerometer", "-",
      excess(beyond_noise(d, d.before.accel, "accel_noise"), d.gap_sigma.accel, d.gap_dof.accel), &out);
  add("gyroscope: noise", "rad/s/sqrt(Hz)", density(d.raw_noise.gyro), &out);
  add("accelerometer: noise", "m/s^2/sqrt(Hz)", density(d.raw_noise.accel), &out);
  return out;
}

}  // namespace

std::vector<Statistic> statistics_of(const Diagnosis& found) {
  std::vector<Statistic> out = plain_statistics(found);
  for (std::size_t i = 0; i < std::min(kMostCauses, found.where.size()); ++i) {
    const Structure& s = found.where[i];
    out.push_back({words_of(s), "-", size_of(s), sigma_of(s), 0, 0});
  }
  return out;
}

std::vector<double> same_of(const std::vector<Statistic>& statistics, const Recording& session,
                            const Diagnosis& other) {
  const std::vector<Statistic> own = plain_statistics(other);
  const std::vector<Structure> structure = structure_of(session, other);
  std::vector<double> out;
  for (std::size_t i = 0; i < statistics.size(); ++i) {
    if (i < own.size()) {
      out.push_back(own[i].measured);
      continue;
    }
    const auto same = std::find_if(structure.begin(), structure.end(),
                                   [&](const Structure& s) { return words_of(s) == statistics[i].name; });
    out.push_back(same == structure.end() ? 0 : size_of(*same));
  }
  return out;
}

}  // namespace host::twin
