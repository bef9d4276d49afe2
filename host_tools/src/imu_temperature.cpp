#include "imu_temperature.h"

#include <algorithm>
#include <cmath>

#include "formatted.h"
#include "quantile.h"

namespace host {
namespace {

constexpr double fastest_K_per_s = 5;  // hot air, 100 K warmer, on a package that follows in 20 s
constexpr double coarse_K = 2;         // columns of 1 K flicker by one step to either side
constexpr double noisiest_K = 5;       // a column that moves more from sample to sample is no thermometer
constexpr double noise_sigmas = 6;     // of differences: one in 10^9 by chance
constexpr double longest_hold_s = 2;   // slow sensors give a reading a second: the last one may be that old
// stretches of wrong readings in a row, after which the sensor's own are taken up again
constexpr std::size_t passed_over = 64;

/// Neighbours that a die can follow, one after the other.
struct Stretch {
  std::vector<std::size_t> samples;
  double held_since = 0;          ///< s, when its last value was first read
  std::size_t chained = 0;        ///< readings of the longest chain that ends here
  std::size_t before = SIZE_MAX;  ///< the stretch before it in there
};

class Readings {
 public:
  explicit Readings(const std::vector<ImuSample>& samples) : samples_(samples) {
    for (std::size_t i = 0; i < samples.size(); ++i)
      if (std::isfinite(samples[i].temperature_degC)) finite_.push_back(i);
    std::vector<double> steps;
    for (std::size_t k = 1; k < finite_.size(); ++k) steps.push_back(std::abs(at(finite_[k]) - at(finite_[k - 1])));
    const double sigma = steps.empty() ? 0 : 1.4826 * quantile(std::move(steps), 0.5);
    step_ = std::clamp(noise_sigmas * sigma, coarse_K, noisiest_K);
  }

  std::size_t size() const { return finite_.size(); }
  double at(std::size_t i) const { return samples_[i].temperature_degC; }

  /// Places that are not of the longest chain of readings that a die can follow.
  std::vector<std::size_t> jumps() const {
    std::vector<Stretch> all = stretches();
    if (all.size() < 2) return {};
    for (std::size_t b = 0; b < all.size(); ++b) chain(all, b);
    const auto last = std::max_element(all.begin(), all.end(),
                                       [](const Stretch& a, const Stretch& b) { return a.chained < b.chained; });
    std::vector<bool> good(all.size());
    for (auto b = static_cast<std::size_t>(last - all.begin()); b != SIZE_MAX; b = all[b].before) good[b] = true;
    std::vector<std::size_t> out;
    for (std::size_t b = 0; b < all.size(); ++b)
      if (!good[b]) out.insert(out.end(), all[b].samples.begin(), all[b].samples.end());
    return out;
  }

 private:
  double seconds(std::size_t i) const { return static_cast<double>(samples_[i].t_ns - samples_.front().t_ns) * 1e-9; }
  double allowed(double dt) const { return step_ + fastest_K_per_s * std::max(0.0, dt); }

  std::vector<Stretch> stretches() const {
    std::vector<Stretch> out;
    for (const std::size_t i : finite_) {
      const std::size_t before = out.empty() ? i : out.back().samples.back();
      const bool goes_on = !out.empty() && std::abs(at(i) - at(before)) <= allowed(seconds(i) - seconds(before));
      if (!goes_on) out.push_back({{}, seconds(i), 0, SIZE_MAX});
      if (at(i) != at(before)) out.back().held_since = seconds(i);
      out.back().samples.push_back(i);
    }
    return out;
  }

  /// The best chain that ends with stretch b.
  void chain(std::vector<Stretch>& all, std::size_t b) const {
    Stretch& to = all[b];
    const std::size_t first = to.samples.front();
    for (std::size_t a = b > passed_over ? b - passed_over : 0; a < b; ++a) {
      const std::size_t last = all[a].samples.back();
      const double age = std::min(longest_hold_s, seconds(last) - all[a].held_since);
      if (all[a].chained <= to.chained ||
          std::abs(at(first) - at(last)) > allowed(seconds(first) - seconds(last) + age))
        continue;
      to.chained = all[a].chained;
      to.before = a;
    }
    to.chained += to.samples.size();
  }

  const std::vector<ImuSample>& samples_;
  std::vector<std::size_t> finite_;
  double step_ = coarse_K;
};

/// Places of the readings that are left.
std::vector<std::size_t> good_places(const std::vector<ImuSample>& samples, const std::vector<std::size_t>& jumps) {
  std::vector<std::size_t> out;
  for (std::size_t i = 0, next = 0; i < samples.size(); ++i) {
    const bool jumped = next < jumps.size() && jumps[next] == i;
    next += jumped ? 1 : 0;
    if (!jumped && std::isfinite(samples[i].temperature_degC)) out.push_back(i);
  }
  return out;
}

bool all_the_same(const std::vector<ImuSample>& samples, const std::vector<std::size_t>& places) {
  return std::all_of(places.begin(), places.end(), [&](std::size_t i) {
    return samples[i].temperature_degC == samples[places.front()].temperature_degC;
  });
}

/// The many are one and the same value, and the few are not: a logger
/// that repeats a constant, zero most of all, between readings.
bool only_the_few_are_readings(const std::vector<ImuSample>& samples, const std::vector<std::size_t>& many,
                               const std::vector<std::size_t>& few) {
  return all_the_same(samples, many) && (samples[many.front()].temperature_degC == 0 || !all_the_same(samples, few));
}

/// The last good reading in the place of each that jumped; before
/// the first good one, that. Returns the farthest jump, K.
double hold(std::vector<ImuSample>& samples, const std::vector<std::size_t>& good,
            const std::vector<std::size_t>& jumps, bool mend) {
  double farthest = 0;
  for (const std::size_t i : jumps) {
    const auto after = std::upper_bound(good.begin(), good.end(), i);
    const double held = samples[after == good.begin() ? good.front() : *(after - 1)].temperature_degC;
    farthest = std::max(farthest, std::abs(samples[i].temperature_degC - held));
    if (mend) samples[i].temperature_degC = held;
  }
  return farthest;
}

}  // namespace

void check_temperature(ImuData* imu, bool mend) {
  if (!imu->has_temperature) return;
  const Readings readings(imu->samples);
  const std::vector<std::size_t> jumps = readings.jumps();
  if (jumps.empty()) return;
  const std::vector<std::size_t> good = good_places(imu->samples, jumps);
  TemperatureJumps& out = imu->temperature_jumps;
  out.count = jumps.size();
  out.of = readings.size();
  out.first_ns = imu->samples[jumps.front()].t_ns;
  out.last_ns = imu->samples[jumps.back()].t_ns;
  out.share = static_cast<double>(jumps.size()) / static_cast<double>(readings.size());
  out.bridged = mend && out.share <= few_temperature_jumps && !only_the_few_are_readings(imu->samples, good, jumps);
  out.farthest_K = hold(imu->samples, good, jumps, out.bridged);
  imu->has_temperature = !mend || out.bridged;
}

std::string temperature_words(const ImuData& imu) {
  const TemperatureJumps& jumps = imu.temperature_jumps;
  if (jumps.count == 0) return "";
  const std::string what = formatted(
      "temperature: %zu of %zu readings (%.2g %%) are up to %.1f K from those before and after, the first at stamp "
      "%lld ns, which no die follows. ",
      jumps.count, jumps.of, 100 * jumps.share, jumps.farthest_K, static_cast<long long>(jumps.first_ns));
  if (jumps.bridged)
    return what +
           "The reading before them is held in their place: look at the bus, and at what the driver writes where it "
           "has no reading.";
  if (imu.has_temperature)
    return what + "A device's log is replayed as it is: effects of temperature that it estimates are wrong by that.";
  return what +
         "Nothing says which are the sensor's own, so that effects of temperature cannot be estimated: write a reading "
         "only where there is one, or the last one.";
}

}  // namespace host
