// Feeds a device log through the C API, each call between the marks of the instruction counter: what the calls of any
// recording take. For targets with files.
//
// usage: count_log LOG SLICES [REQUESTS]      SLICES: of background work after each sample; REQUESTS: calibrations
// asked for on the way
#include <cstdio>
#include <cstdlib>

#include "log/config_fields.h"
extern "C" {  // the counter knows its marks by their names
#include "feed.h"
}

namespace {

using namespace SEGCAL_NS;

alignas(SEGCAL_STORAGE_ALIGNMENT) char memory[SEGCAL_STORAGE_BYTES];
segcal_t* device = nullptr;
int slices_per_sample = 0, requests = 0;
std::uint32_t samples = 0, all_samples = 0;

[[noreturn]] void stop(const char* what) {
  std::fprintf(stderr, "count_log: %s\n", what);
  std::exit(2);
}

void feed_samples(ByteReader in) {
  const std::int64_t t0 = in.integer<std::int64_t>();
  for (std::uint32_t n = in.integer<std::uint32_t>(); n > 0; --n) {
    segcal_imu_t s = {};
    s.t_ns = t0 + in.integer<std::int32_t>();
    for (int i = 0; i < 3; ++i) s.gyro[i] = in.number32();
    for (int i = 0; i < 3; ++i) s.accel[i] = in.number32();
    s.temperature = in.number32();
    feed_sample(device, &s);
    feed_background(device, slices_per_sample);
    if (requests > 0 && ++samples % (all_samples / static_cast<std::uint32_t>(requests + 1)) == 0)
      segcal_request_calibration(device);
  }
}

void feed_tracks(ByteReader in) {
  static segcal_point_t points[SEGCAL_MAX_TRACKS];
  const std::int64_t t = in.integer<std::int64_t>();
  const std::int32_t n = in.integer<std::int32_t>();
  if (n > SEGCAL_MAX_TRACKS) stop("a frame with more points than this profile takes");
  for (std::int32_t i = 0; i < n; ++i) {
    points[i] = segcal_point_t{};
    points[i].track_id = in.integer<std::uint32_t>();
    points[i].camera = in.integer<std::uint8_t>();
    points[i].u = in.number32();
    points[i].v = in.number32();
  }
  feed_frame(device, t, points, n);
}

void mark(int what) {
  if (what == SEGCAL_LOG_NEW_SESSION) segcal_new_session(device);
  if (what == SEGCAL_LOG_REQUEST_CALIBRATION) segcal_request_calibration(device);
  if (what == SEGCAL_LOG_FLUSH) segcal_flush(device);
  if (what != SEGCAL_LOG_CALIBRATE) return;
  segcal_mark_begin();
  segcal_calibrate(device);
  segcal_mark_calibrate();
}

void take_block(LogBlock type, const std::uint8_t* payload, std::size_t n) {
  segcal_config_t config;
  switch (type) {
    case LogBlock::config:
      if (!read_config(payload, n, &config)) stop("a configuration of another layout");
      if (segcal_create(&device, &config, memory, sizeof memory) != SEGCAL_OK) stop("a configuration that is refused");
      return;
    case LogBlock::imu: return feed_samples(ByteReader(payload, n));
    case LogBlock::tracks: return feed_tracks(ByteReader(payload, n));
    case LogBlock::mark: return mark(*payload);
    default: return;
  }
}

/// Calls `visit(type, payload, bytes)` for each block.
template <class Visit>
void each_block(const std::uint8_t* bytes, std::size_t size, Visit visit) {
  for (std::size_t at = kLogMagicBytes; at + kBlockHead <= size;) {
    ByteReader head(bytes + at, kBlockHead);
    head.integer<std::uint32_t>();
    const LogBlock type = static_cast<LogBlock>(head.integer<std::uint16_t>());
    head.integer<std::uint16_t>();
    const std::size_t n = head.integer<std::uint32_t>();
    if (n > size - at - kBlockHead) stop("a block that ends behind the file");
    visit(type, bytes + at + kBlockHead, n);
    at += kBlockHead + n + kBlockTail;
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) stop("usage: count_log LOG SLICES [REQUESTS]");
  slices_per_sample = std::atoi(argv[2]);
  requests = argc > 3 ? std::atoi(argv[3]) : 0;
  std::FILE* const file = std::fopen(argv[1], "rb");
  if (!file || std::fseek(file, 0, SEEK_END) != 0) stop("no such log");
  const std::size_t size = static_cast<std::size_t>(std::ftell(file));
  std::uint8_t* const bytes = static_cast<std::uint8_t*>(std::malloc(size + 1));
  std::rewind(file);
  if (!bytes || std::fread(bytes, 1, size, file) != size || size < 100) stop("the log cannot be read");
  each_block(bytes, size, [](LogBlock type, const std::uint8_t* payload, std::size_t n) {
    if (type == LogBlock::imu) all_samples += static_cast<std::uint32_t>((n - kImuHead) / kImuSample);
    (void)payload;
  });
  each_block(bytes, size, take_block);
  segcal_result_t result;
  segcal_counters_t counters;
  if (!device || segcal_get_counters(device, &counters) != SEGCAL_OK) stop("a log without a configuration");
  segcal_get_result(device, &result);
  std::printf("status %d\ncalibrations %u\nsegments %u\nlate %u\nmissed %u\n", static_cast<int>(result.status),
              counters.calibrations, counters.segments_closed, counters.slices_late, counters.segments_missed);
  return 0;
}
