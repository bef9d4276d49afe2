#include "diagnose/noise_effects.h"

#include <algorithm>
#include <cmath>

#include "diagnose/answer.h"
#include "diagnose/selection.h"

namespace host::diagnosis {
namespace {

/// Factors of the first half of the samples and of the second; 0 where one is too short to tell.
std::vector<std::array<double, 2>> imu_halves(const Recording& recording,
                                              const std::vector<DiagnosedParameter>& factors) {
  std::vector<std::array<double, 2>> out(factors.size(), {0, 0});
  for (int half = 0; half < 2; ++half) {
    Recording part = recording;
    std::vector<ImuSample>& samples = part.imu.samples;
    const auto middle = samples.begin() + static_cast<std::ptrdiff_t>(samples.size() / 2);
    half == 0 ? samples.erase(middle, samples.end()) : samples.erase(samples.begin(), middle);
    const RawNoise noise = raw_imu_noise(part);
    for (std::size_t i = 0; i < factors.size(); ++i) {
      const SensorNoise& sensor = factors[i].name[0] == 'g' ? noise.gyro : noise.accel;
      out[i][half] = sensor.axes[0].density > 0 ? sensor.factor : 0;
    }
  }
  return out;
}

Floor floor_of(const SensorNoise& raw, double stated, double weighed) {
  const bool told = raw.verdict != SensorNoise::Verdict::cannot_tell;
  const double factor = std::max(stated, told ? raw.factor * raw.stated : 0) / weighed;
  return {factor * factor, told ? 2 * factor * raw.sigma * raw.stated / weighed : 0};
}

}  // namespace

std::array<Floor, 3> noise_floors(double known, const PixelNoise& pixels, const RawNoise& raw, const CoreModel& weights,
                                  const ImuNoise& stated) {
  const double factor = std::max(std::sqrt(known), pixels.factor);
  return {Floor{factor * factor, 2 * factor * pixels.sigma},
          floor_of(raw.gyro, stated.gyro_noise_density, weights.gyro_noise_density),
          floor_of(raw.accel, stated.accel_noise_density, weights.accel_noise_density)};
}

NoiseEffect noise_effect(const std::string& name, const std::vector<DiagnosedParameter>& factors,
                         const std::vector<std::array<double, 2>>& halves) {
  NoiseEffect out{named_noise(name, factors), {}, {}};
  for (std::size_t i = 0; i < factors.size(); ++i) {
    const double excess = std::abs(factors[i].value * factors[i].value - 1);
    const bool known = halves[i][0] > 0 && halves[i][1] > 0;
    const double left = known ? std::abs(halves[i][0] * halves[i][0] - halves[i][1] * halves[i][1]) : excess;
    const char sensor = factors[i].name[0];
    const auto add = [sensor](SensorShares* s, double value) {
      (sensor == 'p' ? s->camera : sensor == 'g' ? s->gyro : s->accel) += value;
      s->total += value;
    };
    add(&out.before, excess);
    add(&out.after, left);
  }
  out.effect.gap_closed = out.before.total > 0 ? std::clamp(1 - out.after.total / out.before.total, 0.0, 1.0) : 0;
  return out;
}

void add_noise_gap(const std::vector<NoiseEffect>& noise, Diagnosis* out) {
  const auto add = [](SensorShares* sum, const SensorShares& s) {
    sum->total += s.total;
    sum->camera += s.camera;
    sum->gyro += s.gyro;
    sum->accel += s.accel;
  };
  for (const NoiseEffect& n : noise) {
    add(&out->before, n.before);
    add(&out->after, n.after);
    out->effects.push_back(n.effect);
  }
  out->gap_closed = out->before.total > 0 ? std::clamp(1 - out->after.total / out->before.total, 0.0, 1.0) : 0;
}

std::optional<NoiseEffect> imu_noise_effect(const Recording& recording, const RawNoise& raw, ImuNoise* noise) {
  std::vector<DiagnosedParameter> factors;
  const auto take = [&factors](const SensorNoise& s, const char* name, double* density) {
    if (s.verdict != SensorNoise::Verdict::above) return;
    factors.push_back({name, s.factor, s.sigma, "-"});
    *density *= s.factor;
  };
  take(raw.gyro, "gyro_noise.factor", &noise->gyro_noise_density);
  take(raw.accel, "accel_noise.factor", &noise->accel_noise_density);
  if (factors.empty()) return std::nullopt;
  return noise_effect("imu_noise", factors, imu_halves(recording, factors));
}

NoiseEffect pixel_noise_effect(const PixelNoise& noise, const std::vector<CoreKept>& segments, double ratio) {
  std::vector<CoreKept> half[2];
  for (std::size_t i = 0; i < segments.size(); ++i) half[is_held_out(i) ? 1 : 0].push_back(segments[i]);
  const DiagnosedParameter factor{"pixel_noise.factor", noise.factor, noise.sigma, "-"};
  return noise_effect("pixel_noise", {factor},
                      {{ratio * pixel_noise(half[0]).factor, ratio * pixel_noise(half[1]).factor}});
}

}  // namespace host::diagnosis
