// Fuzz target: a stored device whose records are changed in any way, with all checksums right again, is restored or
// refused; a restored one answers every question, calibrates and is fed: never a crash or a byte out of bounds.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "../fuzz/fuzz_bytes.h"
#include "../support/synthetic_stream.h"
#include "states.h"

namespace {

using namespace test;

void require(bool condition, int line = __builtin_LINE()) {
  if (!condition) std::fprintf(stderr, "fuzz_restore.cpp:%d\n", line);
  if (!condition) std::abort();
}

alignas(SEGCAL_STORAGE_ALIGNMENT) char memory[SEGCAL_STORAGE_BYTES];

segcal_config_t config() {
  segcal_config_t c = SyntheticStream::config();
  c.strategy = SEGCAL_MULTI_SESSION;
  return c;
}

/// Memory with the traces of what was there before.
segcal_t* new_device() {
  segcal_t* device = nullptr;
  const segcal_config_t c = config();
  require(segcal_create(&device, &c, memory, sizeof memory) == SEGCAL_OK);
  return device;
}

const SyntheticStream& stream() {
  static const SyntheticStream instance(11, 14);
  return instance;
}

int finish_store(segcal_store_t* store) {
  int answer;
  while ((answer = segcal_store_work(store, 1000)) == 1) {
  }
  return answer;
}

void feed(segcal_t* device, double seconds) {
  for (std::size_t i = 0; i < seconds * 200; ++i) {
    segcal_push_imu(device, &stream().imu[i]);
    segcal_background(device, 1000000);
    if (i % 20 != 0) continue;
    const SyntheticStream::Frame& frame = stream().frames[i / 20];
    segcal_push_tracks(device, frame.state.t_ns, frame.points.data(),
                       std::min(static_cast<int>(frame.points.size()), SEGCAL_MAX_TRACKS));
  }
}

FakeFlash new_flash() {
  FakeFlash tiny({256, 4096, 2});
  const segcal_flash_t port = tiny.port();
  return FakeFlash({256, 4096, segcal_store_blocks(&port)});
}

/// The records of a device with kept segments and a calibration.
const std::vector<TestReader::Record>& records() {
  static const std::vector<TestReader::Record> all = [] {
    segcal_t* device = new_device();
    feed(device, 14);
    segcal_flush(device);
    segcal_calibrate(device);
    FakeFlash flash = new_flash();
    const segcal_flash_t port = flash.port();
    segcal_store_t store;
    segcal_store_open(&store, &port);
    finish_store(&store);
    require(segcal_save(&store, device) == SEGCAL_OK && finish_store(&store) == SEGCAL_OK);
    TestReader reader;
    const RecordSink sink = reader.sink();
    Ring ring;
    open(&ring, &flash);
    ring.look(&sink);
    require(finish(&ring) == SEGCAL_OK && reader.records.size() >= 4);
    return reader.records;
  }();
  return all;
}

/// Changes numbers: to an edge of their type, to something near, to anything.
void change(FuzzBytes* in, std::vector<TestReader::Record>* records) {
  TestReader::Record& r = (*records)[std::size_t(in->below(int(records->size())))];
  const std::uint32_t edges[] = {0, 1, 0xFFFFFFFFu, 0x7FFFFFFFu, 0x80000000u, 0x7F800000u, 0x7FC00000u, 0x00000100u};
  switch (in->below(8)) {
    case 0: r.info.index = std::uint16_t(in->below(70)); break;
    case 1: r.info.type = std::uint16_t(in->below(7)); break;
    case 2: r.bytes.resize(std::size_t(in->below(int(r.bytes.size()) + 200))); break;
    default: {
      if (r.bytes.size() < 8) return;
      // The numbers of entries stand at the beginning.
      const std::size_t span = in->flag() ? 200 : r.bytes.size();
      const std::size_t at = std::size_t(in->below(int(std::min(span, r.bytes.size() - 4)))) / 4 * 4;
      const std::uint32_t value = edges[in->below(8)];
      if (in->flag())
        std::memcpy(&r.bytes[at], &value, 4);
      else
        r.bytes[at] = std::uint8_t(r.bytes[at] + in->byte());
    }
  }
}

void ask_everything(segcal_t* device) {
  static segcal_result_t result;
  static segcal_point_residual_t points[4000];
  static segcal_imu_residual_t samples[64];
  static segcal_state_t states[64];
  static segcal_landmark_t landmarks[512];
  static segcal_measured_point_t measured[4000];
  static segcal_imu_t imu[4000];
  static double mean[SEGCAL_MAX_PARAMETERS], covariance[SEGCAL_MAX_PARAMETERS * SEGCAL_MAX_PARAMETERS];
  segcal_get_result(device, &result);
  segcal_get_posterior(device, mean, covariance, SEGCAL_MAX_PARAMETERS * SEGCAL_MAX_PARAMETERS);
  for (int slot = 0; slot <= SEGCAL_MAX_SEGMENTS; ++slot) {
    segcal_segment_t segment;
    segcal_link_t link;
    segcal_get_segment(device, slot, &segment);
    segcal_get_link(device, slot, &link);
    segcal_get_point_residuals(device, slot, points, 4000);
    segcal_get_imu_residuals(device, slot, samples, 64);
    segcal_get_keyframes(device, slot, states, 64);
    segcal_get_landmarks(device, slot, landmarks, 512);
    segcal_get_points(device, slot, measured, 4000);
    segcal_get_samples(device, slot, imu, 4000);
  }
  segcal_result_hash(device);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  FuzzBytes in(data, size);
  std::vector<TestReader::Record> changed = records();
  for (int n = 1 + in.below(4); n > 0; --n) change(&in, &changed);
  FakeFlash flash = new_flash();
  Ring ring;
  open(&ring, &flash);
  RecordSource source = {&changed, static_cast<std::uint32_t>(changed.size()),
                         [](void* r, std::uint32_t i) {
                           TestReader::Record& record = (*static_cast<std::vector<TestReader::Record>*>(r))[i];
                           record.info.bytes = static_cast<std::uint32_t>(record.bytes.size());
                           return record.info;
                         },
                         [](void* r, std::uint32_t i, std::uint32_t offset, std::uint8_t* to, std::uint32_t n) {
                           std::memcpy(to, (*static_cast<std::vector<TestReader::Record>*>(r))[i].bytes.data() + offset,
                                       n);
                         },
                         [](void*) { return true; }};
  ring.save(source);
  if (finish(&ring) != SEGCAL_OK) return 0;
  segcal_t* device = new_device();
  segcal_store_t store;
  const segcal_flash_t port = flash.port();
  segcal_store_open(&store, &port);
  finish_store(&store);
  require(segcal_restore(&store, device) == SEGCAL_OK);
  const int answer = finish_store(&store);
  require(answer == SEGCAL_OK || answer == SEGCAL_EMPTY || answer == SEGCAL_ERROR_CONFIG ||
          answer == SEGCAL_ERROR_CAPACITY);
  ask_everything(device);
  segcal_calibrate(device);
  ask_everything(device);
  feed(device, 3);
  segcal_flush(device);
  ask_everything(device);
  return 0;
}
