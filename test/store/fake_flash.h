// NOR flash in memory, with the rules of real parts and their failures. A rule that the caller breaks is counted.
#pragma once

#include <cstdint>
#include <cstring>
#include <functional>
#include <vector>

#include "segcal/store.h"

namespace test {

struct Geometry {
  std::uint32_t program_bytes, erase_bytes, blocks;
};

class FakeFlash {
 public:
  struct Change {
    bool erase;
    std::uint32_t block, offset;
    std::vector<std::uint8_t> bytes;  ///< programmed
  };

  explicit FakeFlash(const Geometry& g)
      : geometry(g),
        cells(std::size_t(g.blocks) * g.erase_bytes),
        used(cells.size() / g.program_bytes, true),
        erasures(g.blocks),
        refuses_erase(g.blocks),
        refuses_program(g.blocks) {
    // As delivered: anything at all.
    for (std::size_t i = 0; i < cells.size(); ++i) cells[i] = static_cast<std::uint8_t>(i * 2654435761u >> 13);
  }

  segcal_flash_t port() {
    return {this, geometry.program_bytes, geometry.erase_bytes, geometry.blocks, read, program, erase, sync};
  }

  /// What power does to one change that was under way: some of its bytes took effect, one of them half.
  void tear(const Change& change, std::uint64_t random) {
    const std::size_t first = std::size_t(change.block) * geometry.erase_bytes + change.offset;
    const std::size_t n = change.erase ? geometry.erase_bytes : change.bytes.size();
    const std::size_t done = random % (n + 1);
    const std::uint8_t half = static_cast<std::uint8_t>(random >> 32);
    for (std::size_t i = 0; i < n && i <= done; ++i) {
      std::uint8_t& cell = cells[first + i];
      const std::uint8_t target = change.erase ? 0xFF : static_cast<std::uint8_t>(cell & change.bytes[i]);
      cell = i < done ? target : static_cast<std::uint8_t>(change.erase ? cell | half : cell & (target | half));
    }
    for (std::size_t i = 0; i < n; ++i) used[(first + i) / geometry.program_bytes] = true;  // not to be relied on
  }
  void apply(const Change& change) { tear(change, change.erase ? geometry.erase_bytes : change.bytes.size()); }

  /// Back to what the last sync guaranteed, and any of the changes since on top of it, each whole, torn or lost.
  void lose_power_reordered(std::uint64_t random) {
    cells = durable;
    for (const Change& change : since_sync) {
      random = random * 6364136223846793005ull + 1442695040888963407ull;
      const std::uint64_t draw = random >> 33;
      if (draw % 4 == 0) continue;
      if (draw % 4 == 1)
        tear(change, draw >> 2 | draw << 40);
      else
        apply(change);
    }
    since_sync.clear();
  }

  std::uint8_t& cell(std::uint32_t block, std::uint32_t offset) {
    return cells[std::size_t(block) * geometry.erase_bytes + offset];
  }

  Geometry geometry;
  std::vector<std::uint8_t> cells, durable;
  std::vector<bool> used;  ///< program unit: not erased since
  std::vector<std::uint32_t> erasures;
  std::vector<bool> refuses_erase, refuses_program;
  struct Stuck {
    std::uint32_t block, offset;
    std::uint8_t mask, value;
  };
  std::vector<Stuck> stuck;  ///< bits that never change, and nobody says so
  std::vector<Change> since_sync;
  bool keeps_changes = false;             ///< fills since_sync and durable
  bool dead = false;                      ///< the medium cannot be reached
  std::uint32_t misread_per_million = 0;  ///< reads that come with one wrong bit
  int broken_rules = 0;
  std::uint64_t operations = 0, reads = 0;  ///< programs and erasures; reads
  std::uint32_t longest_program = 0, longest_read = 0;
  /// Before each program and erasure.
  std::function<void(const Change&)> before;

 private:
  bool inside(std::uint32_t block, std::uint32_t offset, std::uint32_t n) const {
    return block < geometry.blocks && offset <= geometry.erase_bytes && n <= geometry.erase_bytes - offset;
  }
  static FakeFlash& self(void* context) { return *static_cast<FakeFlash*>(context); }
  std::uint64_t draw() {
    state_ = state_ * 6364136223846793005ull + 1442695040888963407ull;
    return state_ >> 33;
  }
  void hold_stuck_bits() {
    for (const Stuck& s : stuck) {
      std::uint8_t& c = cell(s.block, s.offset);
      c = static_cast<std::uint8_t>((c & ~s.mask) | (s.value & s.mask));
    }
  }

  static int read(void* context, std::uint32_t block, std::uint32_t offset, void* to, std::uint32_t n) {
    FakeFlash& f = self(context);
    if (f.dead) return -5;
    if (!f.inside(block, offset, n)) return ++f.broken_rules, -1;
    ++f.reads;
    if (n > f.longest_read) f.longest_read = n;
    std::memcpy(to, &f.cell(block, offset), n);
    if (f.misread_per_million > 0 && f.draw() % 1000000 < f.misread_per_million) {
      static_cast<std::uint8_t*>(to)[f.draw() % n] ^= static_cast<std::uint8_t>(1u << f.draw() % 8);
    }
    return 0;
  }

  static int program(void* context, std::uint32_t block, std::uint32_t offset, const void* from, std::uint32_t n) {
    FakeFlash& f = self(context);
    if (f.dead) return -5;
    const std::uint32_t unit = f.geometry.program_bytes;
    if (!f.inside(block, offset, n) || n == 0 || offset % unit != 0 || n % unit != 0) return ++f.broken_rules, -1;
    if (n > f.longest_program) f.longest_program = n;
    const auto* bytes = static_cast<const std::uint8_t*>(from);
    const Change change{false, block, offset, {bytes, bytes + n}};
    if (f.before) f.before(change);
    ++f.operations;
    if (f.refuses_program[block]) return SEGCAL_FLASH_BAD;
    const std::size_t first = std::size_t(block) * f.geometry.erase_bytes + offset;
    for (std::size_t u = first / unit; u < (first + n) / unit; ++u) {
      if (f.used[u]) ++f.broken_rules;  // programmed twice, or never erased
    }
    f.apply(change);
    f.hold_stuck_bits();
    if (f.keeps_changes) f.since_sync.push_back(change);
    return 0;
  }

  static int erase(void* context, std::uint32_t block) {
    FakeFlash& f = self(context);
    if (f.dead) return -5;
    if (block >= f.geometry.blocks) return ++f.broken_rules, -1;
    const Change change{true, block, 0, {}};
    if (f.before) f.before(change);
    ++f.operations;
    if (f.refuses_erase[block]) return SEGCAL_FLASH_BAD;
    f.apply(change);
    const std::size_t units = f.geometry.erase_bytes / f.geometry.program_bytes;
    for (std::size_t u = block * units; u < (block + 1) * units; ++u) f.used[u] = false;
    ++f.erasures[block];
    f.hold_stuck_bits();
    if (f.keeps_changes) f.since_sync.push_back(change);
    return 0;
  }

  static int sync(void* context) {
    FakeFlash& f = self(context);
    if (f.dead) return -5;
    f.since_sync.clear();
    if (f.keeps_changes) f.durable = f.cells;
    return 0;
  }

  std::uint64_t state_ = 1;
};

}  // namespace test
