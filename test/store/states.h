// States to store: records whose number, lengths and bytes follow from one number, so that a state that comes back is
// known to be one of those that were saved, to the last byte.
#pragma once

#include <string>
#include <vector>

#include "fake_flash.h"
#include "store/ring.h"

namespace test {

using SEGCAL_NS::RecordInfo;
using SEGCAL_NS::RecordSink;
using SEGCAL_NS::RecordSource;
using SEGCAL_NS::Ring;

inline std::uint64_t mixed(std::uint64_t a, std::uint64_t b) {  // splitmix64's finish
  std::uint64_t z = a * 0x9E3779B97F4A7C15ull + b + 1;
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ull;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBull;
  return z ^ (z >> 31);
}

/// State `seed`. `bytes`: in all records, so that rings that hold just two states can be told.
struct TestState {
  std::uint32_t seed, bytes;

  std::uint32_t count() const { return 2 + mixed(seed, 1) % 6; }
  RecordInfo info(std::uint32_t number) const {
    std::uint32_t length = 0, left = bytes;
    for (std::uint32_t i = 0; i <= number; ++i, left -= length) length = i + 1 < count() ? this->length(i) : left;
    return {static_cast<std::uint16_t>(number), static_cast<std::uint16_t>(mixed(seed, 200 + number)), length};
  }
  std::uint8_t byte(std::uint32_t number, std::uint32_t offset) const {
    if (number == 0) return static_cast<std::uint8_t>(seed >> (8 * offset));
    return static_cast<std::uint8_t>(mixed(mixed(seed, number), offset / 8) >> (offset % 8 * 8));
  }
  /// Of all records but the last. At the edges of pages too: none, a head and its tail in just one page, one byte more.
  std::uint32_t length(std::uint32_t number) const {
    static const std::uint32_t kEdges[] = {0, 1, 40, 41, 42, 64, 104, 105, 232, 233};
    const std::uint64_t draw = mixed(seed, 100 + number);
    const std::uint32_t most = bytes / count();
    const std::uint32_t n = draw % 3 == 0 ? kEdges[draw / 3 % 10] : static_cast<std::uint32_t>(draw / 3 % most);
    return number == 0 ? 4 : n < most ? n : most;
  }
  RecordSource source() {
    return {this, count(), [](void* s, std::uint32_t i) { return static_cast<TestState*>(s)->info(i); },
            [](void* s, std::uint32_t i, std::uint32_t offset, std::uint8_t* to, std::uint32_t n) {
              for (std::uint32_t k = 0; k < n; ++k) to[k] = static_cast<TestState*>(s)->byte(i, offset + k);
            },
            [](void*) { return true; }};
  }
};

/// Takes what comes back.
struct TestReader {
  struct Record {
    RecordInfo info;
    std::vector<std::uint8_t> bytes;
    bool closed = false;
  };
  std::vector<Record> records;
  bool ended = false;
  int states = 0;

  RecordSink sink() {
    return {this,
            [](void* r) {
              *static_cast<TestReader*>(r) = TestReader{{}, false, static_cast<TestReader*>(r)->states + 1};
            },
            [](void* r, const RecordInfo& info) {
              static_cast<TestReader*>(r)->records.push_back({info, {}});
              return 0;
            },
            [](void* r, std::uint32_t offset, const std::uint8_t* bytes, std::uint32_t n) {
              std::vector<std::uint8_t>& to = static_cast<TestReader*>(r)->records.back().bytes;
              if (offset != to.size()) return -99;
              to.insert(to.end(), bytes, bytes + n);
              return 0;
            },
            [](void* r) {
              static_cast<TestReader*>(r)->records.back().closed = true;
              return 0;
            },
            [](void* r) {
              static_cast<TestReader*>(r)->ended = true;
              return 0;
            }};
  }
  /// The seed whose state this is, byte for byte; 0 if it is none.
  std::uint32_t seed(std::uint32_t bytes) const {
    if (!ended || records.empty() || records[0].bytes.size() != 4) return 0;
    std::uint32_t seed = 0;
    for (int i = 0; i < 4; ++i) seed |= std::uint32_t(records[0].bytes[i]) << (8 * i);
    const TestState state{seed, bytes};
    if (records.size() != state.count()) return 0;
    for (std::uint32_t i = 0; i < records.size(); ++i) {
      const RecordInfo info = state.info(i);
      const Record& r = records[i];
      if (!r.closed || r.info.type != info.type || r.info.index != info.index || r.info.bytes != info.bytes) return 0;
      if (r.bytes.size() != info.bytes) return 0;
      for (std::uint32_t k = 0; k < info.bytes; ++k) {
        if (r.bytes[k] != state.byte(i, k)) return 0;
      }
    }
    return seed;
  }
};

inline int finish(Ring* ring) {
  while (!ring->step()) {
  }
  return ring->answer();
}

inline int open(Ring* ring, FakeFlash* flash) {
  ring->open(flash->port());
  return finish(ring);
}

inline int save(Ring* ring, std::uint32_t seed, std::uint32_t bytes) {
  TestState state{seed, bytes};
  ring->save(state.source());
  return finish(ring);
}

/// Blocks that any state of so many bytes fits into.
inline std::uint32_t blocks_for(const Geometry& g, std::uint32_t bytes) {
  const std::uint32_t page = g.program_bytes < 64 ? 64 : g.program_bytes;
  const std::uint32_t pages = bytes / page + 2 * 7 + 1, of_block = g.erase_bytes / page - 1;
  return (pages + of_block - 1) / of_block;
}

/// The state that is stored: its seed; 0 for none, kGarbage for one that nobody saved.
constexpr std::uint32_t kGarbage = 0xFFFFFFFFu;
inline std::uint32_t stored(Ring* ring, std::uint32_t bytes) {
  TestReader reader;
  const RecordSink sink = reader.sink();
  ring->look(&sink);
  const int answer = finish(ring);
  if (answer == SEGCAL_EMPTY) return 0;
  const std::uint32_t seed = answer == SEGCAL_OK ? reader.seed(bytes) : 0;
  return seed == 0 ? kGarbage : seed;
}

}  // namespace test
