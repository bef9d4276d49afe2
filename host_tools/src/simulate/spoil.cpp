#include "simulate/spoil.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "angles.h"
#include "simulate/disturb.h"
#include "simulate/random.h"

namespace host::sim::spoil {
namespace {

constexpr double full_scale = 35;  // rad/s, of the gyroscope where the configuration does not say another (segcal.h)
constexpr double width_px = 640, height_px = 480;

std::int64_t ns(double seconds) { return std::llround(1e9 * seconds); }

Random random_of(std::uint64_t seed) { return Random(seed, Stream::stamps); }

template <class Change>
void each_frame(Recording& r, const Change& change) {
  for (CameraData& camera : r.cameras)
    for (Frame& frame : camera.frames) change(frame);
}

template <class Entry, class Stays>
void keep(std::vector<Entry>& entries, const Stays& stays) {
  std::vector<Entry> kept;
  for (std::size_t i = 0; i < entries.size(); ++i)
    if (stays(i)) kept.push_back(entries[i]);
  entries = std::move(kept);
}

}  // namespace

ImuSample& sample(Recording& r, double place) {
  return r.imu.samples[static_cast<std::size_t>(place * static_cast<double>(r.imu.samples.size() - 1))];
}

void jump_imu(Recording& r, double seconds) {
  const std::int64_t middle = disturb::middle_ns(r);
  for (ImuSample& s : r.imu.samples) s.t_ns += s.t_ns >= middle ? ns(seconds) : 0;
}

void jump_camera(Recording& r, double seconds) {
  const std::int64_t middle = disturb::middle_ns(r);
  each_frame(r, [&](Frame& f) { f.t_ns += f.t_ns >= middle ? ns(seconds) : 0; });
}

void swap_samples(Recording& r, std::size_t n) {
  for (std::size_t i = n; i < r.imu.samples.size(); i += n) std::swap(r.imu.samples[i - 1], r.imu.samples[i]);
}

void duplicate(Recording& r, std::size_t every_sample, std::size_t every_frame) {
  const auto twice = [](auto& entries, std::size_t every) {
    std::remove_reference_t<decltype(entries)> out;
    for (std::size_t i = 0; i < entries.size(); ++i) out.insert(out.end(), (i + 1) % every == 0 ? 2 : 1, entries[i]);
    entries = std::move(out);
  };
  twice(r.imu.samples, every_sample);
  for (CameraData& camera : r.cameras) twice(camera.frames, every_frame);
}

void lose_imu(Recording& r, double place, double seconds) {
  const std::int64_t from = sample(r, place).t_ns;
  const std::vector<ImuSample> all = r.imu.samples;
  keep(r.imu.samples, [&](std::size_t i) { return all[i].t_ns < from || all[i].t_ns >= from + ns(seconds); });
}

void lose_bursts(Recording& r, double every_s, double seconds) {
  const std::vector<ImuSample> all = r.imu.samples;
  const std::int64_t first = all.front().t_ns;
  keep(r.imu.samples, [&](std::size_t i) {
    return (all[i].t_ns - first) % ns(every_s) >= ns(seconds) || all[i].t_ns - first < ns(every_s);
  });
}

void drop_samples(Recording& r, double share, std::uint64_t seed) {
  Random random = random_of(seed);
  keep(r.imu.samples, [&](std::size_t) { return random.uniform() >= share; });
}

void drop_frames(Recording& r, double share, std::uint64_t seed) {
  for (CameraData& camera : r.cameras) {
    Random same_for_all_cameras = random_of(seed);
    keep(camera.frames, [&](std::size_t) { return same_for_all_cameras.uniform() >= share; });
  }
}

void halve_imu_rate(Recording& r) {
  const std::size_t half = r.imu.samples.size() / 2;
  keep(r.imu.samples, [&](std::size_t i) { return i < half || i % 2 == 0; });
}

void halve_camera_rate(Recording& r) {
  for (CameraData& camera : r.cameras) {
    const std::size_t half = camera.frames.size() / 2;
    keep(camera.frames, [&](std::size_t i) { return i < half || i % 2 == 0; });
  }
}

void spikes(Recording& r, double share, double value, std::uint64_t seed) {
  Random random = random_of(seed);
  for (ImuSample& s : r.imu.samples) {
    const bool hit = random.uniform() < share;
    const auto axis = static_cast<std::size_t>(random.uniform() * 2.999);
    if (hit) s.accel[axis] = value;
  }
}

void flip_bits(Recording& r, double share, std::uint64_t seed) {
  constexpr double gyro_digit = 2000 * rad_per_deg / 32768, accel_digit = 16 * 9.80665 / 32768;
  Random random = random_of(seed);
  for (ImuSample& s : r.imu.samples) {
    const bool hit = random.uniform() < share;
    const auto axis = static_cast<std::size_t>(random.uniform() * 5.999),
               bit = static_cast<std::size_t>(random.uniform() * 15.999);
    if (!hit) continue;
    double& value = axis < 3 ? s.gyro[axis] : s.accel[axis - 3];
    const double digit = axis < 3 ? gyro_digit : accel_digit;
    const auto raw = static_cast<std::int16_t>(std::lround(value / digit));
    value = digit * static_cast<std::int16_t>(static_cast<std::uint16_t>(raw) ^ (1U << bit));
  }
}

void saturate(Recording& r, double share, bool known) {
  double largest = 0;
  for (const ImuSample& s : r.imu.samples)
    for (const double w : s.gyro) largest = std::max(largest, std::abs(w));
  const double limit = share * largest;
  for (ImuSample& s : r.imu.samples)
    for (double& w : s.gyro)
      if (std::abs(w) > limit) w = std::copysign(known ? full_scale : limit, w);
}

void freeze_accel_z(Recording& r) {
  for (ImuSample& s : r.imu.samples) s.accel[2] = r.imu.samples.front().accel[2];
}

void outliers(Recording& r, double share, double drift, std::uint64_t seed) {
  Random random = random_of(seed);
  std::map<std::uint32_t, std::pair<bool, double>> chosen;  // and the direction it runs off in
  std::map<std::uint32_t, std::int64_t> since;
  each_frame(r, [&](Frame& f) {
    for (TrackPoint& p : f.points) {
      if (!chosen.count(p.track_id)) {
        const bool bad = random.uniform() < share;
        chosen[p.track_id] = {bad, random.uniform(0, two_pi)};
        since[p.track_id] = f.t_ns;
      }
      const auto [bad, heading] = chosen[p.track_id];
      if (!bad) continue;
      const double gone = drift * 1e-9 * static_cast<double>(f.t_ns - since[p.track_id]);
      p.u = drift != 0 ? p.u + gone * std::cos(heading) : random.uniform(0, width_px);
      p.v = drift != 0 ? p.v + gone * std::sin(heading) : random.uniform(0, height_px);
    }
  });
}

void permute_ids(Recording& r, std::size_t every_frame, std::uint64_t seed) {
  Random random = random_of(seed);
  std::size_t count = 0;
  each_frame(r, [&](Frame& f) {
    if (++count % every_frame != 0) return;
    for (std::size_t i = f.points.size(); i > 1; --i)
      std::swap(f.points[i - 1].track_id,
                f.points[static_cast<std::size_t>(random.uniform() * 0.999999 * static_cast<double>(i))].track_id);
  });
}

void reuse_ids(Recording& r, std::uint32_t modulus) {
  each_frame(r, [&](Frame& f) {
    for (TrackPoint& p : f.points) p.track_id %= modulus;
  });
}

void renumber_from_middle(Recording& r) {
  const std::int64_t middle = disturb::middle_ns(r);
  each_frame(r, [&](Frame& f) {
    for (TrackPoint& p : f.points) p.track_id += f.t_ns >= middle ? 1000000 : 0;
  });
}

void cover(Recording& r, double seconds) {
  const std::int64_t middle = disturb::middle_ns(r);
  each_frame(r, [&](Frame& f) {
    if (std::abs(f.t_ns - middle) < ns(seconds / 2)) f.points.clear();
  });
}

void scale_pixels(Recording& r, double factor) {
  each_frame(r, [&](Frame& f) {
    for (TrackPoint& p : f.points) p.u *= factor, p.v *= factor;
  });
}

void move_pixels(Recording& r, double du, double dv) {
  const std::int64_t middle = disturb::middle_ns(r);
  each_frame(r, [&](Frame& f) {
    if (f.t_ns < middle) return;
    for (TrackPoint& p : f.points) p.u += du, p.v += dv;
  });
}

}  // namespace host::sim::spoil
