// Power fails at every program and every erasure of long runs of saves, in the middle of it: after a restart the store
// holds the state before or the one that was being saved, whole, and takes the next one.
//
//   SEGCAL_LONG=1 test_power_cuts       more of both
//   test_power_cuts geometry=2 cut=1374 how=torn                          one cut alone
//   test_power_cuts geometry=2 cut=1374 how=torn second=17 again=reordered   a pair
#include <cstdlib>
#include <memory>

#include "../support/cases.h"
#include "states.h"

using namespace test;

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

struct Case {
  Geometry geometry;
  std::uint32_t state_bytes;
};
// Byte-wise NOR, small pages, a sector of serial NOR, internal flash of a controller, many blocks per state; 0 blocks:
// just two states fit, and a cut leaves the next save no block but those of the one that was interrupted.
const Case kCases[] = {{{1, 512, 0}, 900},      {{8, 1024, 0}, 1500},  {{256, 4096, 0}, 9000},
                       {{32, 4096, 24}, 30000}, {{64, 512, 40}, 3000}, {{128, 131072, 4}, 100000},
                       {{16, 512, 13}, 900}};
constexpr int kGeometries = 7;
Case case_of(int g) {
  Case c = kCases[g];
  if (c.geometry.blocks == 0) c.geometry.blocks = 2 * blocks_for(c.geometry, c.state_bytes);
  return c;
}

bool long_run() { return std::getenv("SEGCAL_LONG") != nullptr; }
bool chosen(const char* key, long value) {
  static const std::string words = selection();
  if (words.empty()) return true;
  const std::string wanted = value_of(words, key);
  return wanted.empty() || wanted == std::to_string(value);
}
bool chosen(const char* key, const char* value) {
  static const std::string words = selection();
  if (words.empty()) return true;
  const std::string wanted = value_of(words, key);
  return wanted.empty() || wanted == value;
}

/// A copy of `flash` as it is when power comes back after a cut in the middle of `change`.
std::unique_ptr<FakeFlash> after_cut(const FakeFlash& flash, const FakeFlash::Change& change, bool reordered,
                                     std::uint64_t random) {
  auto copy = std::make_unique<FakeFlash>(flash);
  copy->before = nullptr;
  if (reordered) {
    copy->since_sync.push_back(change);
    copy->lose_power_reordered(random);
  } else {
    copy->tear(change, random);
  }
  copy->durable = copy->cells;
  copy->since_sync.clear();
  std::fill(copy->used.begin(), copy->used.end(), true);  // a new start knows of no erased block
  return copy;
}

std::string id_of(int geometry, std::uint64_t cut, const char* how, const std::string& second = "") {
  return "geometry=" + std::to_string(geometry) + " cut=" + std::to_string(cut) + " how=" + how + second;
}

void require(bool ok, const std::string& id, const std::string& what) {
  if (!ok) TEST_FAIL_MESSAGE((what + "; run it alone: " + id).c_str());
}

/// After a restart: what is stored is `old_seed` or `new_seed`, and a save of `next` works. Returns what was found.
std::uint32_t check_restart(FakeFlash* flash, std::uint32_t bytes, std::uint32_t old_seed, std::uint32_t new_seed,
                            std::uint32_t next, const std::string& id) {
  Ring ring;
  const int answer = open(&ring, flash);
  require(answer == SEGCAL_OK || (answer == SEGCAL_EMPTY && old_seed == 0), id,
          "not opened: " + std::to_string(answer));
  const std::uint32_t found = stored(&ring, bytes);
  require(found == old_seed || found == new_seed, id,
          "found " + std::to_string(found) + ", not " + std::to_string(old_seed) + " or " + std::to_string(new_seed));
  require(save(&ring, next, bytes) == SEGCAL_OK, id, "the next save failed");
  Ring again;
  open(&again, flash);
  require(stored(&again, bytes) == next, id, "the next save is not found");
  require(flash->broken_rules == 0, id, "a rule of the flash was broken");
  return found;
}

/// Runs saves on geometry `g` until `operations` programs and erasures are done; `at` sees each before it is made.
template <class At>
std::uint64_t run(int g, std::uint64_t operations, At at) {
  const Case c = case_of(g);
  FakeFlash flash(c.geometry);
  flash.keeps_changes = true;
  flash.durable = flash.cells;
  Ring ring;
  open(&ring, &flash);
  std::uint32_t seed = 0;
  flash.before = [&](const FakeFlash::Change& change) { at(flash, change, seed, seed + 1); };
  while (flash.operations < operations) {
    TEST_ASSERT_EQUAL_INT(SEGCAL_OK, save(&ring, seed + 1, c.state_bytes));
    ++seed;
  }
  TEST_ASSERT_EQUAL_INT(0, flash.broken_rules);
  return flash.operations;
}

/// Operations of a run on geometry g: those of small blocks are cheap to check.
std::uint64_t length(int g) {
  return (kCases[g].geometry.erase_bytes > 4096 ? 500
          : kCases[g].state_bytes > 5000        ? 2000
                                                : 4000) *
         (long_run() ? 4 : 1);
}

void test_every_single_cut() {
  std::uint64_t cuts = 0;
  for (int g = 0; g < kGeometries; ++g) {
    if (!chosen("geometry", g) || !value_of(selection(), "second").empty()) continue;
    cuts +=
        run(g, length(g),
            [&](const FakeFlash& flash, const FakeFlash::Change& change, std::uint32_t before, std::uint32_t after) {
              const std::uint64_t cut = flash.operations;
              if (!chosen("cut", static_cast<long>(cut))) return;
              for (const bool reordered : {false, true}) {
                const char* how = reordered ? "reordered" : "torn";
                if (!chosen("how", how)) continue;
                const auto copy = after_cut(flash, change, reordered, mixed(cut, g));
                check_restart(copy.get(), kCases[g].state_bytes, before, after, 1000000 + after, id_of(g, cut, how));
              }
            });
  }
  std::printf("%llu single cuts, each torn and reordered\n", static_cast<unsigned long long>(cuts));
  if (selection().empty()) TEST_ASSERT_GREATER_OR_EQUAL_UINT64(20000, cuts);
}

/// The second cut: while the device that came back saves again.
void check_pair(int g, const FakeFlash& first, std::uint32_t old_seed, std::uint32_t new_seed, std::uint64_t draw,
                const std::string& id) {
  const std::uint32_t bytes = kCases[g].state_bytes;
  FakeFlash flash(first);
  flash.keeps_changes = true;
  Ring ring;
  open(&ring, &flash);
  const std::uint32_t found = stored(&ring, bytes);
  require(found == old_seed || found == new_seed, id, "after the first cut: found " + std::to_string(found));
  const std::uint64_t begin = flash.operations,
                      about = bytes / flash.geometry.program_bytes < 64 ? bytes / 64 + 8 : bytes / 200 + 6;
  const std::uint64_t second = draw % about;
  const bool reordered = draw >> 40 & 1;
  const std::string full_id = id + " second=" + std::to_string(second) + " again=" + (reordered ? "reordered" : "torn");
  bool done = false;
  std::uint32_t next = 2000000 + new_seed, before = found;
  flash.before = [&](const FakeFlash::Change& change) {
    if (done || flash.operations - begin != second) return;
    done = true;
    const auto copy = after_cut(flash, change, reordered, mixed(draw, 7));
    check_restart(copy.get(), bytes, before, next, next + 1000000, full_id);
  };
  for (int saves = 0; saves < 8 && !done; ++saves) {
    require(save(&ring, next, bytes) == SEGCAL_OK, full_id, "the save after the first cut failed");
    before = next++;
  }
}

void test_pairs_of_cuts() {
  const std::uint64_t wanted = long_run() ? 24000 : 3000;
  std::uint64_t pairs = 0;
  for (int g = 0; g < kGeometries; ++g) {
    if (!chosen("geometry", g)) continue;
    const std::uint64_t here = length(g) / (long_run() ? 4 : 1), each = wanted / kGeometries + 1;
    const std::uint64_t step = here > each ? here / each : 1, sampled = here / step;
    const int repeats = static_cast<int>((each + sampled - 1) / sampled);
    run(g, here,
        [&](const FakeFlash& flash, const FakeFlash::Change& change, std::uint32_t before, std::uint32_t after) {
          const std::uint64_t cut = flash.operations;
          if (cut % step != 0 || !chosen("cut", static_cast<long>(cut))) return;
          for (int r = 0; r < repeats; ++r) {
            const std::uint64_t draw = mixed(mixed(cut, g), 50 + r);
            const bool reordered = draw >> 41 & 1;
            const char* how = reordered ? "reordered" : "torn";
            if (!chosen("how", how)) continue;
            const auto copy = after_cut(flash, change, reordered, draw);
            check_pair(g, *copy, before, after, draw, id_of(g, cut, how));
            ++pairs;
          }
        });
  }
  std::printf("%llu pairs of cuts\n", static_cast<unsigned long long>(pairs));
  if (selection().empty()) TEST_ASSERT_GREATER_OR_EQUAL_UINT64(wanted, pairs);
}

}  // namespace

int main(int argc, char** argv) {
  select_cases(argc, argv);
  UNITY_BEGIN();
  RUN_TEST(test_every_single_cut);
  RUN_TEST(test_pairs_of_cuts);
  return UNITY_END();
}
