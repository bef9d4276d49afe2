#include "review/stated.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "diagnose/imu_noise.h"
#include "diagnose/pixel_noise.h"
#include "formatted.h"
#include "gravity.h"

namespace host::review {
namespace {

constexpr double kAbove = noise_factor_high;  // 1.6: where diagnosis says that an IMU is noisier than stated
constexpr double kBelow = 0.5;  // sigmas are twice too wide: nobody is misled, but half of the information is lost
constexpr double kTypicalError = 0.03;  // m/s^2: 9.80665 is off by up to that in most places where people live
constexpr double kPriorSigmas = 3.5;    // once in 2000 devices
constexpr double kStudent2 = 31.6;      // |t| with two degrees of freedom: once in 1000 devices
constexpr double kSeen = 5;             // sigmas of the common scale, below which nothing is said of it

/// `above`: what it means that there is more noise than stated, and what to do.
void judge(const char* name, const char* sensor, double factor, double sigma, const std::string& above,
           const std::string& advice, std::vector<Note>* out) {
  std::string verdict;
  if (factor - 3 * sigma > kAbove) verdict = above;
  if (factor + 3 * sigma < kBelow)
    verdict =
        "sigmas are too large by up to that, unless it was stated on purpose, for drift or for what a filter in the "
        "sensor hides. " +
        advice;
  if (verdict.empty()) return;
  out->push_back(
      {name, factor,
       formatted("%s noise is %.2f +- %.1g times what was stated: %s", sensor, factor, sigma, verdict.c_str())});
}

std::string to_state(const char* entry, double value) { return formatted("State %s %.3g (--config)", entry, value); }

/// Links are weighed by what the samples around them show where that is beyond 1.5 times the stated
/// (lib/src/sensors/roughness.h).
void judge_imu(const char* name, const char* sensor, const SensorNoise& noise, const char* entry,
               std::vector<Note>* out) {
  const std::string advice = to_state(entry, noise.factor * noise.stated),
                    weighed = "what is beyond 1.5 times was taken from the samples themselves";
  const std::string above = noise.verdict == SensorNoise::Verdict::above
                                ? weighed + ". " + advice
                                : "vibration, or motion that is too fast for the samples; " + weighed;
  judge(name, sensor, noise.factor, noise.sigma, above, advice, out);
}

/// Shares by which the accelerometer's three scales left the start; false where one was held or there is no covariance.
bool scale_steps(const CoreResult& r, std::array<double, 3>* step, double* prior_sigma, double* common_sigma) {
  const std::size_t n = r.parameters.size();
  if (r.covariance.size() != n * n) return false;
  std::array<std::size_t, 3> at{};
  for (std::size_t k = 0; k < 3; ++k) {
    const std::string name = std::string("accel.s") + "xyz"[k];
    const auto p = std::find_if(r.parameters.begin(), r.parameters.end(),
                                [&name](const CoreParameter& q) { return q.name == name; });
    if (p == r.parameters.end() || p->verdict == "fixed") return false;
    at[k] = static_cast<std::size_t>(p - r.parameters.begin());
    (*step)[k] = p->value / p->initial - 1;
    *prior_sigma = p->prior_sigma;
  }
  double sum = 0;
  for (const std::size_t i : at)
    for (const std::size_t j : at) sum += r.covariance[i * n + j];
  *common_sigma = std::sqrt(std::max(0.0, sum)) / 3;
  return true;
}

}  // namespace

std::vector<Note> notes_on_noise(const Recording& recording, const ReplayResult& result) {
  std::vector<Note> out;
  const RawNoise raw = raw_imu_noise(recording);
  judge_imu("gyro_noise", "gyroscope", raw.gyro, "gyroscope_noise_density", &out);
  judge_imu("accel_noise", "accelerometer", raw.accel, "accelerometer_noise_density", &out);
  const diagnosis::PixelNoise pixel = diagnosis::pixel_noise(result.kept);
  if (pixel.sigma > 0) {
    // Neighbours show white noise alone: stated without the walk it would make sigmas too small.
    const TrackNoise& tracks = result.track_noise;
    const std::string advice =
        tracks.points == 0
            ? to_state("pixel_sigma_px", pixel.factor * result.model.pixel_sigma)
            : formatted("--estimate-track-noise weighs by what the tracks show, %.2g px and %.2g px/sqrt(s)",
                        tracks.white_px, tracks.walk_px_per_sqrt_s);
    judge("pixel_noise", "corner", pixel.factor, pixel.sigma, "sigmas are too small by up to that. " + advice, advice,
          &out);
  }
  return out;
}

std::vector<Note> notes_on_gravity(const CoreOptions& options, const ReplayResult& result) {
  std::array<double, 3> step{};
  double prior_sigma = 0, sigma = 0;
  if (!scale_steps(result.result, &step, &prior_sigma, &sigma)) return {};
  const double common = (step[0] + step[1] + step[2]) / 3, g = result.model.gravity;
  double spread = 0;
  for (const double s : step) spread += 0.5 * (s - common) * (s - common);
  const double by_prior = std::abs(common) / std::sqrt(prior_sigma * prior_sigma / 3 + sigma * sigma);
  const double by_spread = std::abs(common) / std::sqrt(spread / 3 + sigma * sigma);
  if (std::abs(common) > kSeen * sigma && (by_prior > kPriorSigmas || by_spread > kStudent2)) {
    if (std::abs(g * (1 + common) - kStandardGravity) > 2 * kTypicalError)
      return {{"gravity", 1 + common,
               formatted("all three accelerometer scales left the start by %+.2f +- %.2f %%, which gravity does not "
                         "explain (it would be %.2f m/s^2): check the accelerometer's unit, range and noise",
                         100 * common, 100 * sigma, g * (1 + common))}};
    return {{"gravity", 1 + common,
             formatted("all three accelerometer scales left the start by %+.2f +- %.2f %%, which sensors seldom do "
                       "together: with gravity %.4f m/s^2 in place of %.5g they would have stayed. No residual tells "
                       "the two apart. State gravity in --config, by m_s2 or by latitude_deg and height_m",
                       100 * common, 100 * sigma, g * (1 + common), g)}};
  }
  const double share = kTypicalError / g;
  if (options.gravity > 0 || sigma > share) return {};
  return {{"gravity", 1,
           formatted("gravity is not stated, %.5f m/s^2 is taken: where it is off by %.2f (Earth has 9.76 to 9.83), "
                     "accel.s* and all lengths, p_CI too, are off by %.2f %%, %.1f sigma of accel.s*, and no residual "
                     "shows it. State it in --config, by latitude_deg and height_m",
                     kStandardGravity, kTypicalError, 100 * share, share / sigma)}};
}

}  // namespace host::review
