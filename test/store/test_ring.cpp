// The ring of states on flash that ages and fails: bad blocks, stuck bits, misread and flipped bits, a newer format,
// other geometries; how evenly it wears; how much one step does.
#include <algorithm>
#include <fstream>
#include <iterator>
#include <memory>

#include "../support/cases.h"
#include "states.h"

using namespace test;
using SEGCAL_NS::BlockHead;

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

constexpr std::uint32_t kBytes = 5000;
const Geometry kFlash = {16, 1024, 40};

void check_equal(const Id& id, const char* what, double expected, double actual) {
  check_near(id, what, expected, actual, 0);
}

void check_stored(FakeFlash* flash, std::uint32_t seed, const Id& id, std::uint32_t bytes = kBytes) {
  Ring ring;
  open(&ring, flash);
  check_equal(id, "state", seed, stored(&ring, bytes));
  check_equal(id, "broken rules", 0, flash->broken_rules);
}

void test_empty_flash_is_empty() {
  FakeFlash flash(kFlash);
  Ring ring;
  TEST_ASSERT_EQUAL_INT(SEGCAL_EMPTY, open(&ring, &flash));
  TEST_ASSERT_EQUAL_UINT32(0, stored(&ring, kBytes));
}

void test_what_was_saved_comes_back() {
  for (const Geometry& g : {Geometry{1, 512, 40},
                            {2, 512, 40},
                            {4, 4096, 6},
                            {8, 1024, 40},
                            {64, 512, 60},
                            {128, 2048, 20},
                            {256, 4096, 8},
                            {256, 131072, 2},
                            {32, 131072, 3}}) {
    FakeFlash flash(g);
    Ring ring;
    open(&ring, &flash);
    for (std::uint32_t seed = 1; seed <= 60; ++seed) {
      const Id id =
          Id().add("check", "round_trip").add("program", g.program_bytes).add("erase", g.erase_bytes).add("seed", seed);
      check_equal(id, "answer", SEGCAL_OK, save(&ring, seed, kBytes));
      check_equal(id, "the same ring", seed, stored(&ring, kBytes));
      check_stored(&flash, seed, id);
    }
  }
}

/// No piece does more than one erasure, or one program of a page and its reading back, or one read of a page.
void test_a_step_is_bounded() {
  FakeFlash flash(kFlash);
  flash.keeps_changes = true;
  Ring ring;
  ring.open(flash.port());
  TestReader reader;
  TestState state{7, kBytes};
  const RecordSink sink = reader.sink();
  for (int round = 0; round < 6; ++round) {
    for (;;) {
      const std::uint64_t operations = flash.operations, reads = flash.reads;
      const bool done = ring.step();
      TEST_ASSERT_LESS_OR_EQUAL_UINT64(1, flash.operations - operations);
      TEST_ASSERT_LESS_OR_EQUAL_UINT64(2, flash.reads - reads);
      if (done) break;
    }
    if (round % 2 == 0)
      ring.save(state.source());
    else
      ring.look(&sink);
  }
  TEST_ASSERT_LESS_OR_EQUAL_UINT32(SEGCAL_STORE_PAGE_MAX, flash.longest_program);
  TEST_ASSERT_LESS_OR_EQUAL_UINT32(SEGCAL_STORE_PAGE_MAX, flash.longest_read);
}

/// When the commit is programmed, everything before it is on the medium; and when a save is done, the commit is.
void test_the_commit_waits_for_sync() {
  FakeFlash flash(kFlash);
  flash.keeps_changes = true;
  Ring ring;
  open(&ring, &flash);
  std::size_t waiting = 0;
  flash.before = [&](const FakeFlash::Change&) { waiting = flash.since_sync.size(); };
  for (std::uint32_t seed = 1; seed < 30; ++seed) {
    save(&ring, seed, kBytes);
    TEST_ASSERT_EQUAL_UINT64(0, waiting);  // at the last change, the commit
    TEST_ASSERT_EQUAL_UINT64(0, flash.since_sync.size());
  }
}

/// Each block is erased as often as any other, whether the saves end well or power fails in each of them.
void test_wear_is_spread() {
  for (const bool cuts : {false, true}) {
    FakeFlash flash(kFlash);
    auto ring = std::make_unique<Ring>();
    open(ring.get(), &flash);
    for (std::uint32_t seed = 1; seed <= 1500; ++seed) {
      if (cuts && seed % 8 != 0) {
        // Gives up somewhere, and starts again.
        TestState state{seed, kBytes};
        ring->save(state.source());
        for (std::uint64_t steps = mixed(seed, 3) % 100; steps > 0 && !ring->step(); --steps) {
        }
        ring = std::make_unique<Ring>();
        open(ring.get(), &flash);
      } else {
        TEST_ASSERT_EQUAL_INT(SEGCAL_OK, save(ring.get(), seed, kBytes));
      }
    }
    const auto [least, most] = std::minmax_element(flash.erasures.begin(), flash.erasures.end());
    std::printf("%s: blocks erased %u to %u times\n", cuts ? "interrupted saves" : "whole saves", *least, *most);
    // The ring goes round: all the same but for the round that is under way. After a cut a stretch that leaves too
    // little room is jumped over, so that the spread is that of chance: 8 % here.
    TEST_ASSERT_LESS_OR_EQUAL_UINT32(cuts ? *least + *least / 5 : *least + 1, *most);
  }
}

/// Blocks that refuse, and bits that stay: skipped as long as there are enough others; then the last state stays.
void test_bad_blocks() {
  for (int bad = 0; bad < 32; bad += 3) {
    for (std::uint32_t run = 0; run < 12; ++run) {
      FakeFlash flash(kFlash);
      for (int i = 0; i < bad; ++i) {
        const std::uint32_t block = mixed(run, i) % kFlash.blocks;
        const std::uint32_t kind = mixed(run, i) >> 20 & 3;
        if (kind == 0)
          flash.refuses_erase[block] = true;
        else if (kind == 1)
          flash.refuses_program[block] = true;
        else
          flash.stuck.push_back({block, static_cast<std::uint32_t>(mixed(run, 99 + i) % kFlash.erase_bytes), 0x10,
                                 static_cast<std::uint8_t>(kind == 2 ? 0x10 : 0)});
      }
      Ring ring;
      open(&ring, &flash);
      std::uint32_t last = 0, full = 0;
      for (std::uint32_t seed = 1; seed <= 40; ++seed) {
        const Id id = Id().add("check", "bad_blocks").add("bad", bad).add("run", run).add("seed", seed);
        const int answer = save(&ring, seed, kBytes);
        check_true(id, "answer is neither OK nor FULL", answer == SEGCAL_OK || answer == SEGCAL_ERROR_FULL);
        if (answer == SEGCAL_OK)
          last = seed;
        else
          ++full;
        check_stored(&flash, last, id);
      }
      // A state takes 6 blocks here, and two of them must find room.
      if (bad <= 9)
        check_equal(Id().add("check", "bad_blocks").add("bad", bad).add("run", run), "saves refused", 0, full);
    }
  }
}

void test_too_small_flash_says_so() {
  FakeFlash flash({16, 1024, 8});  // one state fits, two do not
  Ring ring;
  open(&ring, &flash);
  TEST_ASSERT_EQUAL_INT(SEGCAL_OK, save(&ring, 1, kBytes));
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_FULL, save(&ring, 2, kBytes));
  check_stored(&flash, 1, Id().add("check", "too_small"));
}

/// A medium that does not answer: an error, and when it is back what was stored is there.
void test_dead_medium() {
  FakeFlash flash(kFlash);
  Ring ring;
  open(&ring, &flash);
  save(&ring, 1, kBytes);
  TestState state{2, kBytes};
  ring.save(state.source());
  for (int i = 0; i < 30; ++i) ring.step();
  flash.dead = true;
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_STORAGE, finish(&ring));
  Ring again;
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_STORAGE, open(&again, &flash));
  TEST_ASSERT_FALSE(again.known());
  flash.dead = false;
  check_stored(&flash, 1, Id().add("check", "dead_medium"));
}

/// Reads that come wrong now and then do not lose what is stored right: it is read again.
void test_misread_bits() {
  FakeFlash flash(kFlash);
  Ring ring;
  open(&ring, &flash);
  save(&ring, 1, kBytes);
  save(&ring, 2, kBytes);
  flash.misread_per_million = 1500;  // one in seven readings of the state, which takes about 100 reads
  int newest = 0;
  for (int i = 0; i < 300; ++i) {
    Ring reader;
    open(&reader, &flash);
    const std::uint32_t found = stored(&reader, kBytes);
    TEST_ASSERT_TRUE(found == 2 || found == 1 || found == 0);  // never anything else
    newest += found == 2 ? 1 : 0;
  }
  // A state's first head misread once loses it for this search: 40 heads are read to find it, each right with 0.9985;
  // three readings of the rest are enough.
  TEST_ASSERT_GREATER_OR_EQUAL_INT(280, newest);
}

/// Any single byte that changes in the newest state, for good: the one before it comes back, never a mixture.
void test_every_flipped_byte() {
  const Geometry small = {16, 512, 16};
  FakeFlash flash(small);
  Ring ring;
  open(&ring, &flash);
  save(&ring, 1, 900);
  const std::vector<std::uint32_t> erasures = flash.erasures;
  save(&ring, 2, 900);
  int older = 0;
  for (std::size_t i = 0; i < flash.cells.size(); ++i) {
    FakeFlash copy(flash);
    copy.cells[i] ^= static_cast<std::uint8_t>(1u << i % 8);
    Ring reader;
    open(&reader, &copy);
    const std::uint32_t found = stored(&reader, 900);
    const Id id = Id().add("check", "flipped").add("byte", i);
    check_true(id, "found neither state", found == 1 || found == 2);
    const std::size_t block = i / small.erase_bytes;
    if (flash.erasures[block] == erasures[block]) check_equal(id, "in a block that the save did not take", 2, found);
    older += found == 1 ? 1 : 0;
  }
  TEST_ASSERT_GREATER_THAN_INT(900, older);  // each of its bytes counts
}

/// Two states of the same number (power failed, and a head that could not be read then can be now): blocks of one in
/// the other do not count, not even where each record is one block and right in itself.
void test_blocks_of_another_state_do_not_count() {
  FakeFlash flash[2] = {FakeFlash(kFlash), FakeFlash(kFlash)};
  for (int i = 0; i < 2; ++i) {
    static std::uint8_t filling;
    filling = static_cast<std::uint8_t>(i);
    RecordSource source = {
        nullptr, 5,
        [](void*, std::uint32_t n) {
          return RecordInfo{static_cast<std::uint16_t>(n), 0, 936};
        },
        [](void*, std::uint32_t, std::uint32_t, std::uint8_t* to, std::uint32_t n) { std::memset(to, filling, n); },
        [](void*) { return true; }};
    Ring ring;
    open(&ring, &flash[i]);
    ring.save(source);
    TEST_ASSERT_EQUAL_INT(SEGCAL_OK, finish(&ring));
  }
  for (std::uint32_t block = 0; block < 7; ++block) {
    FakeFlash spliced(flash[0]);
    std::copy_n(&flash[1].cell(block, 0), kFlash.erase_bytes, &spliced.cell(block, 0));
    Ring ring;
    const Id id = Id().add("check", "spliced").add("block", block);
    // Only the block that is not theirs may be another's. Page 0,
    // the head, and 15 pages of a record: block 5 has the commit.
    check_equal(id, "answer", block < 6 ? SEGCAL_EMPTY : SEGCAL_OK, open(&ring, &spliced));
    segcal_store_info_t info;
    ring.fill(&info);
    check_equal(id, "states passed over", block < 6 ? 1 : 0, info.passed_over);
  }
}

/// The stretch behind an interrupted save turns out too short
/// because of a bad block: the save begins again where all is free.
void test_a_stretch_that_is_too_short() {
  FakeFlash flash({16, 1024, 20});
  Ring ring;
  open(&ring, &flash);
  save(&ring, 1, kBytes);  // blocks 0 to 5
  TestState state{2, 7000};
  RecordSource source = state.source();
  source.unchanged = [](void* s) { return static_cast<TestState*>(s)->seed == 2; };
  ring.save(source);
  while (flash.erasures[13] == 0) ring.step();
  state.seed = 0;
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_BUSY, finish(&ring));
  flash.refuses_erase[16] = true;  // 14 to 19 would just do
  Ring again;
  open(&again, &flash);
  TEST_ASSERT_EQUAL_INT(SEGCAL_OK, save(&again, 3, kBytes));
  check_stored(&flash, 3, Id().add("check", "short_stretch"));
}

void test_newer_format_is_refused() {
  FakeFlash flash(kFlash);
  Ring ring;
  open(&ring, &flash);
  save(&ring, 1, kBytes);
  BlockHead head;
  TEST_ASSERT_TRUE(SEGCAL_NS::decode(&flash.cell(0, 0), &head));
  // A newer minor one is read.
  head.minor = SEGCAL_STORE_MINOR + 1;
  SEGCAL_NS::encode(head, &flash.cell(0, 0));
  check_stored(&flash, 1, Id().add("check", "newer_minor"));
  head.major = SEGCAL_STORE_MAJOR + 1;
  SEGCAL_NS::encode(head, &flash.cell(0, 0));
  const std::vector<std::uint8_t> cells = flash.cells;
  Ring newer;
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_VERSION, open(&newer, &flash));
  TEST_ASSERT_FALSE(newer.known());  // nothing can be saved over it
  segcal_store_info_t info;
  newer.fill(&info);
  TEST_ASSERT_EQUAL_UINT32(SEGCAL_STORE_MAJOR + 1, info.format_major);
  TEST_ASSERT_TRUE(cells == flash.cells);
}

std::vector<std::uint8_t> stored_cells(const char* file) {
  std::ifstream in(std::string(SEGCAL_FIXTURES "/store/") + file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

/// Stores that earlier formats wrote, with three states in them,
/// are read for ever. (1.1 differs from 1.0 by its number alone.)
void test_earlier_formats_are_read() {
  for (const char* file : {"format_1_0.bin", "format_1_2.bin", "format_1_3.bin"}) {
    FakeFlash flash({16, 512, 16});
    const std::vector<std::uint8_t> cells = stored_cells(file);
    TEST_ASSERT_EQUAL_UINT64_MESSAGE(flash.cells.size(), cells.size(), file);
    flash.cells = cells;
    check_stored(&flash, 3, Id().add("check", file), 900);
  }
}

/// Today's format is written as it was: other bytes are another format, with a number and a fixture of its own.
void test_the_format_stays() {
  TEST_ASSERT_TRUE_MESSAGE(SEGCAL_STORE_MAJOR == 1 && SEGCAL_STORE_MINOR == 3,
                           "a new format: add its fixture and compare with that one");
  FakeFlash now({16, 512, 16});
  std::fill(now.cells.begin(), now.cells.end(), 0xFF);
  Ring ring;
  open(&ring, &now);
  for (std::uint32_t seed = 1; seed <= 3; ++seed) save(&ring, seed, 900);
  TEST_ASSERT_TRUE(now.cells == stored_cells("format_1_3.bin"));
}

/// Who saves changes it meanwhile: that save ends, the state before stays, the next one is taken.
void test_a_source_that_changes() {
  FakeFlash flash(kFlash);
  Ring ring;
  open(&ring, &flash);
  save(&ring, 1, kBytes);
  TestState state{2, kBytes};
  RecordSource source = state.source();
  static int asked;
  asked = 0;
  source.unchanged = [](void*) { return ++asked < 25; };
  ring.save(source);
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_BUSY, finish(&ring));
  check_stored(&flash, 1, Id().add("check", "changes"));
  TEST_ASSERT_EQUAL_INT(SEGCAL_OK, save(&ring, 3, kBytes));
  check_stored(&flash, 3, Id().add("check", "changes"));
}

}  // namespace

int main(int argc, char** argv) {
  select_cases(argc, argv);
  UNITY_BEGIN();
  RUN_TEST(test_empty_flash_is_empty);
  RUN_TEST(test_what_was_saved_comes_back);
  RUN_TEST(test_a_step_is_bounded);
  RUN_TEST(test_the_commit_waits_for_sync);
  RUN_TEST(test_wear_is_spread);
  RUN_TEST(test_bad_blocks);
  RUN_TEST(test_too_small_flash_says_so);
  RUN_TEST(test_dead_medium);
  RUN_TEST(test_misread_bits);
  RUN_TEST(test_every_flipped_byte);
  RUN_TEST(test_blocks_of_another_state_do_not_count);
  RUN_TEST(test_a_stretch_that_is_too_short);
  RUN_TEST(test_newer_format_is_refused);
  RUN_TEST(test_earlier_formats_are_read);
  RUN_TEST(test_the_format_stays);
  RUN_TEST(test_a_source_that_changes);
  return UNITY_END();
}
