// A device whose background is too slow: its log says where work was late, and the host comes to the same bits.
#include <algorithm>

#include "../support/cases.h"
#include "../support/synthetic_stream.h"
#include "device_log/device_log.h"
#include "replay/replay.h"
#include "segcal/log.h"

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

using test::Id;
using test::SyntheticStream;
using Bytes = std::vector<std::uint8_t>;

int append(void* context, const void* bytes, std::size_t n) {
  Bytes* out = static_cast<Bytes*>(context);
  const auto* first = static_cast<const std::uint8_t*>(bytes);
  out->insert(out->end(), first, first + n);
  return 0;
}

/// 24 s with a calibration of its own and one that is asked for; hashes each two seconds and at the end.
Bytes log_of_device(int slices, bool noted, std::uint32_t* late, bool when_due = false) {
  static const SyntheticStream stream(7, 24);
  segcal_config_t config = SyntheticStream::config();
  config.keep_segments = 3;
  std::vector<std::uint8_t> memory(segcal_storage_bytes() + SEGCAL_STORAGE_ALIGNMENT), block(SEGCAL_LOG_BLOCK_BYTES);
  void* storage = memory.data();
  std::size_t room = memory.size();
  std::align(SEGCAL_STORAGE_ALIGNMENT, segcal_storage_bytes(), storage, room);
  Bytes out;
  segcal_log_t log;
  segcal_t* device;
  segcal_log_begin(&log, &config, block.data(), block.size(), append, &out);
  TEST_ASSERT_EQUAL_INT(SEGCAL_OK, segcal_create(&device, &config, storage, room));
  if (when_due) segcal_work_when_due(device, 1);
  for (std::size_t i = 0; i < stream.imu.size(); ++i) {
    segcal_log_imu(&log, &stream.imu[i]);
    segcal_push_imu(device, &stream.imu[i]);
    if (noted) segcal_log_fed(&log, device);
    if (i % 20 == 0) {
      const SyntheticStream::Frame& frame = stream.frames[i / 20];
      const int n = std::min(static_cast<int>(frame.points.size()), SEGCAL_MAX_TRACKS);
      segcal_log_tracks(&log, frame.state.t_ns, frame.points.data(), n);
      segcal_push_tracks(device, frame.state.t_ns, frame.points.data(), n);
      if (noted) segcal_log_fed(&log, device);
    }
    if (i == 3000) {
      segcal_log_mark(&log, SEGCAL_LOG_REQUEST_CALIBRATION);
      segcal_request_calibration(device);
    }
    if (i % 400 == 399) segcal_log_hash(&log, segcal_result_hash(device));
    segcal_background(device, slices);
  }
  segcal_log_mark(&log, SEGCAL_LOG_FLUSH);
  while (segcal_flush_slices(device, 100) == 1) {
  }
  segcal_log_hash(&log, segcal_result_hash(device));
  segcal_log_end(&log);
  segcal_progress_t progress;
  segcal_progress(device, &progress);
  *late = progress.late;
  return out;
}

/// Of the hashes in the log, how many the host does not come to.
int others(const Bytes& bytes) {
  const host::DeviceLog log = host::parse_device_log("x.segcal", bytes, host::Damaged::refuse);
  host::ReplayOptions options;
  options.core.calibration = log.calibration;
  options.core.device_config = log.sessions[0].device->config;
  options.profile = "mobile";
  const host::ReplayResult replayed = host::replay(log.sessions, options);
  TEST_ASSERT_EQUAL_UINT(13, replayed.hash_checks.size());
  return static_cast<int>(std::count_if(replayed.hash_checks.begin(), replayed.hash_checks.end(),
                                        [](const auto& check) { return check.expected != check.found; }));
}

void test_a_late_device_replays_to_its_bits() {
  for (const int slices : {0, 1, 3, 64}) {
    const Id id = Id().add("slices", slices);
    std::uint32_t late = 0;
    const Bytes bytes = log_of_device(slices, true, &late);
    test::check_near(id, "other hashes", 0, others(bytes), 0);
    test::check_true(id, "late with few slices", (late > 0) == (slices < 64));
    // Without the notes the host does what the device did not.
    if (late > 0)
      test::check_between(id, "other hashes without notes", 1, others(log_of_device(slices, false, &late)), 13);
  }
}

/// Without any background, in calls that do what is due: nothing is late, a start in motion neither.
void test_a_device_that_does_what_is_due() {
  std::uint32_t late = 1;
  const Bytes bytes = log_of_device(0, true, &late, true);
  TEST_ASSERT_EQUAL_UINT(0, late);
  TEST_ASSERT_EQUAL_INT(0, others(bytes));
}

}  // namespace

int main(int argc, char** argv) {
  test::select_cases(argc - 1, argv + 1);
  UNITY_BEGIN();
  RUN_TEST(test_a_late_device_replays_to_its_bits);
  RUN_TEST(test_a_device_that_does_what_is_due);
  return UNITY_END();
}
