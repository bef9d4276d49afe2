// Fuzz target: an image of a store, changed anywhere and in any way, heads and
// checksums put right again now and then, is looked through to an end: never a crash,
// a byte out of bounds, or a search without end; and what is saved next is there.
#include <cstdlib>

#include "../fuzz/fuzz_bytes.h"
#include "states.h"

namespace {

using namespace test;

constexpr Geometry kFlash = {16, 512, 24};
constexpr std::uint32_t kBytes = 1500;

void require(bool condition) {
  if (!condition) std::abort();
}

int finish_bounded(Ring* ring) {
  // Each of at most 24 states is read three times, and each block of it looked for among all.
  for (int steps = 0; !ring->step(); ++steps) require(steps < 24 * 3 * 24 * (24 + 8) + 1000);
  return ring->answer();
}

/// Makes a changed page look like one that was written.
void put_right(FuzzBytes* in, FakeFlash* flash, std::uint32_t block) {
  if (in->flag()) {
    SEGCAL_NS::BlockHead head{};
    head.generation = std::uint32_t(in->below(9));
    head.place = std::uint16_t(in->below(5));
    head.taken = std::uint16_t(in->below(7));
    head.erase_bytes = kFlash.erase_bytes;
    head.page_bytes = 64;
    head.major = std::uint16_t(in->below(40) == 0 ? 2 : 1);
    SEGCAL_NS::encode(head, &flash->cell(block, 0));
  } else {
    const std::uint32_t lengths[] = {0, 12, 40, 100, 5000, 1u << 28, 0xFFFFFFF0u, 0xFFFFFFFFu};
    const SEGCAL_NS::RecordInfo record = {std::uint16_t(in->flag() ? 0xFFFF : in->below(4)), 0, lengths[in->below(8)]};
    SEGCAL_NS::encode(record, std::uint32_t(in->below(9)), std::uint32_t(in->below(4)),
                      &flash->cell(block, 64 * (1 + std::uint32_t(in->below(7)))));
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const FakeFlash& valid = [] {
    static FakeFlash flash(kFlash);
    Ring ring;
    open(&ring, &flash);
    for (std::uint32_t seed = 1; seed <= 7; ++seed) save(&ring, seed, kBytes);
    return std::ref(flash);
  }();
  FuzzBytes in(data, size);
  FakeFlash flash(valid);
  while (!in.empty()) {
    const std::uint32_t block = std::uint32_t(in.below(kFlash.blocks));
    switch (in.below(4)) {
      case 0: put_right(&in, &flash, block); break;
      case 1:
        std::memcpy(&flash.cell(block, 0), &flash.cell(std::uint32_t(in.below(kFlash.blocks)), 0), kFlash.erase_bytes);
        break;
      case 2: std::memset(&flash.cell(block, std::uint32_t(in.below(512))), in.flag() ? 0xFF : 0, 1); break;
      default: flash.cell(block, std::uint32_t(in.below(512))) ^= in.byte();
    }
  }
  Ring ring;
  ring.open(flash.port());
  const int answer = finish_bounded(&ring);
  require(answer == SEGCAL_OK || answer == SEGCAL_EMPTY || answer == SEGCAL_ERROR_VERSION);
  if (answer == SEGCAL_ERROR_VERSION) return 0;
  TestReader reader;
  const RecordSink sink = reader.sink();
  ring.look(&sink);
  finish_bounded(&ring);
  TestState state{77, kBytes};
  ring.save(state.source());
  const int saved = finish_bounded(&ring);
  require(saved == SEGCAL_OK || saved == SEGCAL_ERROR_FULL);
  if (saved != SEGCAL_OK) return 0;
  Ring again;
  open(&again, &flash);
  require(stored(&again, kBytes) == 77);
  return 0;
}
