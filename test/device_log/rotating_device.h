// A device that lives through sessions and a power-off, with a log for each session (segcal/log.h).
#pragma once

#include <unity.h>

#include <algorithm>
#include <memory>

#include "../api/api_fixture.h"
#include "../store/fake_flash.h"
#include "segcal/log.h"

namespace test {

using Bytes = std::vector<std::uint8_t>;

constexpr int kSessions = 4;

inline const SyntheticStream& session(int i) {
  static const SyntheticStream sessions[kSessions] = {SyntheticStream(11, 14), SyntheticStream(12, 13),
                                                      SyntheticStream(13, 12), SyntheticStream(14, 10)};
  return sessions[i];
}

inline segcal_config_t rotating_config() {
  segcal_config_t c = SyntheticStream::config();
  c.strategy = SEGCAL_MULTI_SESSION;
  c.keep_segments = 3;
  c.segment_s = 1;
  c.condense = SEGCAL_MAX_EPOCHS > 0 ? 1 : 0;
  return c;
}

inline int finish(segcal_store_t* store, int begun) {
  while (begun == SEGCAL_OK || begun == 1) {
    begun = segcal_store_work(store, 5);
    if (begun == SEGCAL_OK || begun == SEGCAL_EMPTY) break;
  }
  return begun;
}

inline int save(const segcal_flash_t& flash, segcal_t* device) {
  segcal_store_t store;
  finish(&store, segcal_store_open(&store, &flash));
  return finish(&store, segcal_save(&store, device));
}

/// A log under way.
struct Writer {
  segcal_log_t log;
  Bytes block = Bytes(SEGCAL_LOG_BLOCK_BYTES), bytes;

  explicit Writer(const segcal_config_t& c) {
    TEST_ASSERT_EQUAL_INT(SEGCAL_OK, segcal_log_begin(&log, &c, block.data(), block.size(), append, this));
  }
  Writer(const Writer&) = delete;
  static int append(void* context, const void* from, std::size_t n) {
    Bytes& out = static_cast<Writer*>(context)->bytes;
    const auto* first = static_cast<const std::uint8_t*>(from);
    out.insert(out.end(), first, first + n);
    return 0;
  }
  int state(segcal_t* device) {
    segcal_flash_t flash;
    const int error = segcal_log_state(&log, device, &flash);
    return error == SEGCAL_OK ? save(flash, device) : error;
  }
  /// One session, of a device that is too slow for its background with few `slices`.
  void feed(segcal_t* device, int s, int slices) {
    for (std::size_t i = 0; i < session(s).imu.size(); ++i) {
      segcal_log_imu(&log, &session(s).imu[i]);
      segcal_push_imu(device, &session(s).imu[i]);
      segcal_log_fed(&log, device);
      if (i % 20 == 0) {
        const SyntheticStream::Frame& frame = session(s).frames[i / 20];
        const int n = std::min(static_cast<int>(frame.points.size()), SEGCAL_MAX_TRACKS);
        segcal_log_tracks(&log, frame.state.t_ns, frame.points.data(), n);
        segcal_push_tracks(device, frame.state.t_ns, frame.points.data(), n);
        segcal_log_fed(&log, device);
      }
      segcal_background(device, slices);
    }
  }
  void end(segcal_t* device, bool calibrates) {
    segcal_log_mark(&log, SEGCAL_LOG_FLUSH);
    segcal_flush(device);
    if (calibrates) {
      segcal_log_mark(&log, SEGCAL_LOG_CALIBRATE);
      segcal_calibrate(device);
    }
    segcal_log_hash(&log, segcal_result_hash(device));
    segcal_log_end(&log);
  }
};

/// Where work is late, it stays late.
inline segcal_t* created(Storage* storage, const segcal_config_t& config) {
  segcal_t* device = nullptr;
  TEST_ASSERT_EQUAL_INT(SEGCAL_OK, segcal_create(&device, &config, storage->data, segcal_storage_bytes()));
  return device;
}

/// A device behind its first session, and that session's log.
struct AgedDevice {
  Storage storage = Storage(0xA5);
  segcal_t* device;
  Writer first = Writer(rotating_config());

  explicit AgedDevice(int slices) : device(created(&storage, rotating_config())) {
    first.feed(device, 0, slices);
    first.end(device, true);
    segcal_new_session(device);
  }
};

/// A log for each session: the first device lives through two, a second one is restored for the third, which does not
/// calibrate at its end, and for the fourth.
inline std::vector<Bytes> logs_of_devices(int slices) {
  const segcal_config_t c = rotating_config();
  FakeFlash tiny({256, 4096, 2});
  const segcal_flash_t geometry = tiny.port();
  FakeFlash flash({256, 4096, segcal_store_blocks(&geometry)});
  auto storage = std::make_unique<Storage>(0xA5);
  segcal_t* device = created(storage.get(), c);
  std::vector<Bytes> out;
  for (int s = 0; s < kSessions; ++s) {
    if (s == 2) {  // power-off
      const segcal_flash_t port = flash.port();
      TEST_ASSERT_EQUAL_INT(SEGCAL_OK, save(port, device));
      storage = std::make_unique<Storage>(0x5A, SEGCAL_STORAGE_ALIGNMENT);
      device = created(storage.get(), c);
      segcal_store_t store;
      finish(&store, segcal_store_open(&store, &port));
      TEST_ASSERT_EQUAL_INT(SEGCAL_OK, finish(&store, segcal_restore(&store, device)));
    } else if (s > 0) {
      segcal_new_session(device);
    }
    Writer log(c);
    if (s > 0) TEST_ASSERT_EQUAL_INT(SEGCAL_OK, log.state(device));
    log.feed(device, s, slices);
    log.end(device, s != 2);
    out.push_back(log.bytes);
  }
  return out;
}

}  // namespace test
