// A device log written with the C API, as firmware does it, and what is in it call by call.
#pragma once

#include <unity.h>

#include <cstring>
#include <limits>
#include <string>
#include <vector>

#include "../support/random.h"
#include "device_log/device_log.h"
#include "segcal/log.h"

namespace test {

inline int append(void* context, const void* bytes, std::size_t n) {
  auto* out = static_cast<std::vector<std::uint8_t>*>(context);
  const auto* first = static_cast<const std::uint8_t*>(bytes);
  out->insert(out->end(), first, first + n);
  return 0;
}

inline segcal_config_t log_config() {
  segcal_config_t config{};
  config.n_cameras = 2;
  for (segcal_camera_t& camera : config.camera) {
    camera.intrinsics[0] = camera.intrinsics[1] = 300.25;
    camera.q_CI[0] = 1;
  }
  config.camera[1].p_CI[0] = 0.1;
  config.gyro_noise_density = 3e-4;
  config.seed = 0x123456789ABCDEF0ull;
  config.outdated_level = -1;
  config.has_temperature = 1;
  config.n_terms = 1;
  config.term[0].b = 3;
  config.term_value[0] = 0.5;
  return config;
}

/// What a call brought, as bits.
using Bits = std::vector<std::uint64_t>;

inline std::uint64_t bits_of(float value) {
  std::uint32_t bits;
  std::memcpy(&bits, &value, sizeof bits);
  return bits;
}

/// A writer, and the calls made so far.
class LoggedCalls {
 public:
  explicit LoggedCalls(std::size_t block_bytes = SEGCAL_LOG_BLOCK_BYTES) : block_(block_bytes) {
    const segcal_config_t config = log_config();
    TEST_ASSERT_EQUAL_INT(SEGCAL_OK, segcal_log_begin(&log_, &config, block_.data(), block_.size(), append, &bytes));
  }
  LoggedCalls(const LoggedCalls&) = delete;

  void imu(const segcal_imu_t& s) {
    TEST_ASSERT_EQUAL_INT(SEGCAL_OK, segcal_log_imu(&log_, &s));
    calls.push_back({0, static_cast<std::uint64_t>(s.t_ns)});
    for (float v : s.gyro) calls.back().push_back(bits_of(v));
    for (float v : s.accel) calls.back().push_back(bits_of(v));
    calls.back().push_back(bits_of(s.temperature));
  }
  /// Points of camera 0 first.
  void tracks(std::int64_t t_ns, const std::vector<segcal_point_t>& points) {
    TEST_ASSERT_EQUAL_INT(SEGCAL_OK, segcal_log_tracks(&log_, t_ns, points.data(), static_cast<int>(points.size())));
    calls.push_back({1, static_cast<std::uint64_t>(t_ns)});
    for (const segcal_point_t& p : points) {
      for (std::uint64_t bits : {std::uint64_t(p.track_id), std::uint64_t(p.camera), bits_of(p.u), bits_of(p.v)})
        calls.back().push_back(bits);
    }
  }
  void mark(int mark) {
    TEST_ASSERT_EQUAL_INT(SEGCAL_OK, segcal_log_mark(&log_, mark));
    calls.push_back({2, static_cast<std::uint64_t>(mark)});
  }
  void hash(std::uint64_t value) {
    TEST_ASSERT_EQUAL_INT(SEGCAL_OK, segcal_log_hash(&log_, value));
    calls.push_back({3, value});
  }
  void sync() { TEST_ASSERT_EQUAL_INT(SEGCAL_OK, segcal_log_sync(&log_)); }
  void end() { TEST_ASSERT_EQUAL_INT(SEGCAL_OK, segcal_log_end(&log_)); }

  std::vector<std::uint8_t> bytes;
  std::vector<Bits> calls;

 private:
  std::vector<std::uint8_t> block_;
  segcal_log_t log_;
};

/// Everything that the fields can hold: repeats, jumps either way, not-a-number, empty frames, both cameras, marks.
inline void log_session(LoggedCalls* log, std::uint32_t seed, int frames) {
  Random random(seed);
  std::int64_t t = 1700000000000000000;
  for (int f = 0; f < frames; ++f) {
    for (int i = 0; i < 10; ++i) {
      segcal_imu_t s{};
      t += 5000000;
      s.t_ns = t;
      for (int k = 0; k < 3; ++k) {
        s.gyro[k] = static_cast<float>(random.normal());
        s.accel[k] = static_cast<float>(9.8 * random.normal());
      }
      s.temperature = static_cast<float>(random.uniform(-20, 60));
      if (f == 1 && i == 3) s.t_ns -= 20000000;
      if (f == 1 && i == 5) s.gyro[1] = std::numeric_limits<float>::quiet_NaN();
      if (f == 1 && i == 6) s.accel[2] = -0.0f;
      if (f == 1 && i == 7) s.accel[0] = std::numeric_limits<float>::denorm_min();
      if (f == 2 && i == 4) t += 7000000000;  // beyond what a block's stamps span
      if (f == 2 && i == 6) s.t_ns = std::numeric_limits<std::int64_t>::min();
      if (f == 2 && i == 7) s.t_ns = std::numeric_limits<std::int64_t>::max();
      log->imu(s);
    }
    std::vector<segcal_point_t> points;
    for (int i = 0; i < (f == 1 ? 0 : 6); ++i) {
      points.push_back({static_cast<std::uint32_t>(7 * f + i), i / 3, static_cast<float>(640 * random.uniform(0, 1)),
                        static_cast<float>(480 * random.uniform(0, 1))});
    }
    log->tracks(t + 1, points);
  }
}

/// The calls of a log that was read, as LoggedCalls has them.
inline std::vector<Bits> calls_of(const host::DeviceLog& log) {
  std::vector<Bits> out;
  for (std::size_t s = 0; s < log.sessions.size(); ++s) {
    const host::Recording& session = log.sessions[s];
    if (s > 0) out.push_back({2, SEGCAL_LOG_NEW_SESSION});
    std::size_t sample = 0, frame = 0;
    for (const host::DeviceCall& call : session.device->calls) {
      if (call.what == host::DeviceCall::sample) {
        const host::ImuSample& x = session.imu.samples[sample++];
        out.push_back({0, static_cast<std::uint64_t>(x.t_ns)});
        for (double v : x.gyro) out.back().push_back(bits_of(static_cast<float>(v)));
        for (double v : x.accel) out.back().push_back(bits_of(static_cast<float>(v)));
        out.back().push_back(bits_of(static_cast<float>(x.temperature_degC)));
      } else if (call.what == host::DeviceCall::frame) {
        out.push_back({1, static_cast<std::uint64_t>(session.cameras[0].frames[frame].t_ns)});
        for (std::size_t c = 0; c < session.cameras.size(); ++c) {
          for (const host::TrackPoint& p : session.cameras[c].frames[frame].points) {
            for (std::uint64_t bits : {std::uint64_t(p.track_id), std::uint64_t(c), bits_of(static_cast<float>(p.u)),
                                       bits_of(static_cast<float>(p.v))})
              out.back().push_back(bits);
          }
        }
        ++frame;
      } else if (call.what == host::DeviceCall::hash) {
        out.push_back({3, call.hash_value});
      } else {
        out.push_back(
            {2, std::uint64_t(call.what == host::DeviceCall::flush ? SEGCAL_LOG_FLUSH : SEGCAL_LOG_CALIBRATE)});
      }
    }
  }
  return out;
}

inline host::DeviceLog parsed(const std::vector<std::uint8_t>& bytes, host::Damaged damaged = host::Damaged::refuse) {
  return host::parse_device_log("x.segcal", bytes, damaged);
}

}  // namespace test
