#include "stamps/stray_frames.h"

#include <algorithm>

#include "quantile.h"

namespace host {
namespace {

// Two neighbours that changed places are one interval apart, and cost one image whichever is left out.
constexpr double nearest_stray = 1.5;       // of the usual interval, ahead
constexpr double most_strays = 0.1;         // of the images; more are a clock that was set back, or a log out of order
constexpr double most_ahead_of_imu = 0.01;  // of the IMU's samples; more are a clock that was set back for all sensors
// after the IMU's last sample: the core takes no such image (device_stream.h)
constexpr std::int64_t beyond_imu_ns = 2000000000;

using Stamps = std::vector<std::int64_t>;

/// Places of the longest chain of stamps that do not go back, of those up to `last`.
std::vector<std::size_t> chain_of(const Stamps& t, std::int64_t last) {
  std::vector<std::size_t> ends, before(t.size());  // ends[n]: where the chain of n + 1 places ends that ends lowest
  for (std::size_t i = 0; i < t.size(); ++i) {
    if (t[i] > last) continue;
    const auto at = std::upper_bound(ends.begin(), ends.end(), t[i],
                                     [&t](std::int64_t value, std::size_t end) { return value < t[end]; });
    before[i] = at == ends.begin() ? i : *(at - 1);
    if (at == ends.end()) {
      ends.push_back(i);
    } else {
      *at = i;
    }
  }
  std::vector<std::size_t> chain(ends.size());
  for (std::size_t n = ends.size(), i = n > 0 ? ends.back() : 0; n-- > 0; i = before[i]) chain[n] = i;
  return chain;
}

double usual_interval(const Stamps& t, const std::vector<std::size_t>& chain) {
  std::vector<double> dt;
  for (std::size_t k = 1; k < chain.size(); ++k) dt.push_back(static_cast<double>(t[chain[k]] - t[chain[k - 1]]));
  return dt.size() < 3 ? 0 : quantile(std::move(dt), 0.5);
}

/// Places that the chain leaves out, between two of it, ahead of both by
/// `apart`; those after `last` wherever the chain goes on, or behind a jump.
std::vector<std::size_t> places_ahead(const Stamps& t, std::int64_t last) {
  const std::vector<std::size_t> chain = chain_of(t, last);
  const double apart = nearest_stray * usual_interval(t, chain);
  std::vector<std::size_t> out;
  if (!(apart > 0)) return out;
  std::size_t begin = 0;
  for (const std::size_t next : chain) {
    const auto is_apart = [&](std::size_t from, std::size_t to) {
      return static_cast<double>(t[to] - t[from]) > apart;
    };
    // else a clock that was set back after them
    const bool jumps = begin == 0 || (begin < next && is_apart(begin - 1, begin));
    for (std::size_t i = begin; i < next; ++i)
      if (t[i] > last || (jumps && is_apart(next, i))) out.push_back(i);
    begin = next + 1;
  }
  // At the end, as where a tracker sorted the images: after the samples, and not as of a camera that ran on.
  const bool jumps = !chain.empty() && begin < t.size() && static_cast<double>(t[begin] - t[chain.back()]) > apart;
  for (std::size_t i = begin; jumps && i < t.size(); ++i)
    if (t[i] > last) out.push_back(i);
  return out;
}

template <typename Stamped>
Stamps stamps_of(const std::vector<Stamped>& entries) {
  Stamps out;
  for (const Stamped& entry : entries) out.push_back(entry.t_ns);
  return out;
}

bool imu_was_set_back(const Stamps& imu) {
  return static_cast<double>(places_ahead(imu, INT64_MAX).size()) > most_ahead_of_imu * static_cast<double>(imu.size());
}

std::vector<std::size_t> strays_of(const Stamps& t, std::int64_t last) {
  std::vector<std::size_t> strays = places_ahead(t, last);
  const auto inside = std::count_if(strays.begin(), strays.end(), [&](std::size_t i) { return t[i] <= last; });
  if (static_cast<double>(inside) > most_strays * static_cast<double>(t.size()))
    strays.erase(std::remove_if(strays.begin(), strays.end(), [&](std::size_t i) { return t[i] <= last; }),
                 strays.end());
  return strays;
}

}  // namespace

void set_strays_aside(Recording* recording) {
  if (recording->device || recording->imu.samples.empty()) return;
  const Stamps imu = stamps_of(recording->imu.samples);
  const std::int64_t last = *std::max_element(imu.begin(), imu.end()) + beyond_imu_ns;
  for (CameraData& camera : recording->cameras) {
    const std::vector<std::size_t> strays = strays_of(stamps_of(camera.frames), last);
    if (strays.empty() || imu_was_set_back(imu)) continue;
    std::vector<Frame> kept;
    for (std::size_t i = 0, next = 0; i < camera.frames.size(); ++i) {
      const bool stray = next < strays.size() && strays[next] == i;
      next += stray ? 1 : 0;
      (stray ? camera.strays : kept).push_back(std::move(camera.frames[i]));
    }
    camera.frames = std::move(kept);
  }
}

}  // namespace host
