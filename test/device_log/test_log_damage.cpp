// Damaged device logs: a torn end is survived, damage in the middle is named and refused or left out, and no value that
// was not written ever comes out.
#include <algorithm>
#include <random>
#include <set>

#include "../support/cases.h"
#include "log/format.h"
#include "log_fixture.h"

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

using namespace test;
using Bytes = std::vector<std::uint8_t>;

const LoggedCalls& whole() {
  static LoggedCalls* log = nullptr;
  if (!log) {
    log = new LoggedCalls;
    log_session(log, 3, 4);
    log->hash(17);
    log->mark(SEGCAL_LOG_NEW_SESSION);
    log_session(log, 4, 3);
    log->mark(SEGCAL_LOG_CALIBRATE);
    log->end();
  }
  return *log;
}

/// Offsets of the blocks' heads.
std::vector<std::size_t> heads() {
  std::vector<std::size_t> out;
  for (const host::LogBlockView& block : host::find_blocks(whole().bytes).blocks) out.push_back(block.offset);
  return out;
}

bool is_prefix(const std::vector<Bits>& part, const std::vector<Bits>& all) {
  return part.size() <= all.size() && std::equal(part.begin(), part.end(), all.begin());
}

/// The error's text; empty if there is none.
std::string refusal(const Bytes& bytes) {
  try {
    parsed(bytes);
    return "";
  } catch (const host::InputError& error) {
    return error.what();
  }
}

void check_says(const Id& id, const std::string& text, const std::vector<std::string>& words) {
  for (const std::string& word : words) {
    check_true(id, ("'" + text + "' says '" + word + "'").c_str(), text.find(word) != std::string::npos);
  }
}

/// Cut anywhere: what was written before comes back, and the cut is told. Cut before the configuration: refused.
void test_torn_at_every_byte() {
  const Bytes& all = whole().bytes;
  const std::size_t first_data = heads()[2];
  for (std::size_t n = 0; n < all.size(); ++n) {
    const Id id = Id().add("bytes", n);
    const Bytes part(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(n));
    if (n < first_data) {
      check_says(id, refusal(part), {"x.segcal: byte "});
      continue;
    }
    const host::DeviceLog log = parsed(part);
    check_true(id, "one note", log.notes.size() == 1);
    check_true(id, "the calls before the cut", is_prefix(calls_of(log), whole().calls));
    const std::vector<std::size_t> at = heads();
    const std::size_t last = *std::prev(std::upper_bound(at.begin(), at.end(), n));
    if (n > last)
      check_says(id, log.notes[0], {"byte " + std::to_string(last), "the last " + std::to_string(n - last) + " bytes"});
    if (n == last) check_says(id, log.notes[0], {"did not close it"});
  }
}

/// Flash that was erased before: the rest of the last page reads as ones.
void test_torn_into_erased_flash() {
  Bytes bytes(whole().bytes.begin(), whole().bytes.begin() + static_cast<std::ptrdiff_t>(heads()[6] + 40));
  bytes.resize(bytes.size() + 512, 0xFF);
  const host::DeviceLog log = parsed(bytes);
  TEST_ASSERT_EQUAL_INT(1, log.notes.size());
  TEST_ASSERT_TRUE(is_prefix(calls_of(log), whole().calls));
  Bytes closed = whole().bytes;
  closed.resize(closed.size() + 512, 0xFF);
  TEST_ASSERT_TRUE(parsed(closed).notes.empty());
}

void test_damage_is_named() {
  const std::size_t block = heads()[3];
  Bytes bytes = whole().bytes;
  bytes[block + 30] ^= 4;
  check_says(Id().add("case", "payload"), refusal(bytes),
             {"x.segcal: byte " + std::to_string(block) + ": expected CRC 0x", ", found 0x", "--salvage"});
  bytes = whole().bytes;
  bytes[block + 9] ^= 1;  // the length
  check_says(Id().add("case", "length"), refusal(bytes),
             {"byte " + std::to_string(block) + ": expected the head of a block with CRC 0x", ", found 0x"});
  bytes = whole().bytes;
  bytes.erase(bytes.begin() + static_cast<std::ptrdiff_t>(block),
              bytes.begin() + static_cast<std::ptrdiff_t>(heads()[4]));
  check_says(Id().add("case", "missing"), refusal(bytes),
             {"byte " + std::to_string(block) + ": expected block 3, found block 4"});
  bytes = whole().bytes;
  bytes.insert(bytes.begin() + static_cast<std::ptrdiff_t>(block),
               whole().bytes.begin() + static_cast<std::ptrdiff_t>(heads()[2]),
               whole().bytes.begin() + static_cast<std::ptrdiff_t>(block));
  check_says(Id().add("case", "twice"), refusal(bytes),
             {"byte " + std::to_string(block) + ": expected block 3, found block 2"});
  bytes = whole().bytes;
  bytes[0] = 0x88;
  check_says(Id().add("case", "magic"), refusal(bytes), {"byte 0: expected the eight bytes"});
}

/// A block as a writer that knows more would make it.
Bytes with_block(std::uint16_t type, const Bytes& payload) {
  Bytes bytes(whole().bytes.begin(), whole().bytes.begin() + static_cast<std::ptrdiff_t>(heads()[2]));
  Bytes block(16 + payload.size() + 4);
  SEGCAL_NS::ByteWriter head(block.data(), 16);
  head.integer(SEGCAL_NS::kBlockMark);
  head.integer(type);
  head.integer(std::uint16_t(2));
  head.integer(static_cast<std::uint32_t>(payload.size()));
  head.integer(SEGCAL_NS::crc32(block.data(), 12));
  std::copy(payload.begin(), payload.end(), block.begin() + 16);
  SEGCAL_NS::ByteWriter tail(block.data() + 16 + payload.size(), 4);
  tail.integer(SEGCAL_NS::crc32(payload.data(), payload.size()));
  bytes.insert(bytes.end(), block.begin(), block.end());
  return bytes;
}

void test_whole_blocks_with_wrong_content_are_refused() {
  Bytes sample(12 + 32, 0);
  sample[8] = 1;
  TEST_ASSERT_EQUAL_STRING("", refusal(with_block(2, sample)).c_str());
  sample[8] = 2;
  check_says(Id().add("case", "count"), refusal(with_block(2, sample)), {"expected 2 samples, found 32 bytes"});
  Bytes point(12 + 13, 0);
  point[8] = 1;
  TEST_ASSERT_EQUAL_STRING("", refusal(with_block(3, point)).c_str());
  point[16] = 2;
  check_says(Id().add("case", "camera"), refusal(with_block(3, point)),
             {"expected cameras below 2, found a point of camera 2"});
  check_says(Id().add("case", "type"), refusal(with_block(9, {})), {"expected a block type from 0 to 7, found 9"});
  check_says(Id().add("case", "mark"), refusal(with_block(4, {9, 0, 0, 0})), {"expected a mark from 1 to 5, found 9"});
  check_says(Id().add("case", "short"), refusal(with_block(5, {1, 2})), {"expected another number of bytes"});
  check_says(Id().add("case", "long"), refusal(with_block(6, {1})), {"expected another number of bytes"});
  check_says(Id().add("case", "second configuration"), refusal(with_block(1, {})), {"found a second one"});
  Bytes format(64, 0);
  format[0] = 1;
  check_says(Id().add("case", "format"), refusal(with_block(0, format)), {"expected log format 2, found 1"});
}

/// Nothing comes out that did not go in: refused, or cut short at the end with a note.
void check_never_wrong(const Id& id, const Bytes& bytes) {
  try {
    const host::DeviceLog log = parsed(bytes);
    check_true(id, "the calls before the damage", is_prefix(calls_of(log), whole().calls));
    check_true(id, "as written, or noted", !log.notes.empty() || calls_of(log) == whole().calls);
  } catch (const host::InputError& error) {
    check_says(id, error.what(), {"x.segcal: byte "});
  }
}

void test_every_bit() {
  Bytes bytes = whole().bytes;
  for (std::size_t bit = 0; bit < 8 * bytes.size(); ++bit) {
    bytes[bit / 8] ^= static_cast<std::uint8_t>(1 << bit % 8);
    check_never_wrong(Id().add("bit", bit), bytes);
    bytes[bit / 8] ^= static_cast<std::uint8_t>(1 << bit % 8);
  }
}

/// What is saved are calls that were made, in their order.
void check_salvage(const Id& id, const Bytes& bytes) {
  try {
    const host::DeviceLog log = parsed(bytes, host::Damaged::leave_out);
    std::size_t at = 0;
    for (const Bits& call : calls_of(log)) {
      while (at < whole().calls.size() && whole().calls[at] != call) ++at;
      check_true(id, "a call that was made", at++ < whole().calls.size());
    }
  } catch (const host::InputError& error) {
    check_says(id, error.what(), {"x.segcal: byte "});
  }
}

/// Bits turned, stretches overwritten, doubled, taken out and cut off, up to three at a time.
void test_random_damage() {
  for (std::uint32_t seed = 1; seed <= 3000; ++seed) {
    const Id id = Id().add("seed", seed);
    if (!selected(id.text())) continue;
    std::mt19937 random(seed);
    Bytes bytes = whole().bytes;
    bool moved = false;
    for (int k = 1 + static_cast<int>(random() % 3); k > 0 && !bytes.empty(); --k) {
      const std::size_t from = random() % bytes.size(), n = 1 + random() % 200, to = std::min(from + n, bytes.size());
      const auto first = bytes.begin() + static_cast<std::ptrdiff_t>(from),
                 last = bytes.begin() + static_cast<std::ptrdiff_t>(to);
      switch (random() % 5) {
        case 0: bytes[from] ^= static_cast<std::uint8_t>(1 << random() % 8); break;
        case 1: std::generate(first, last, [&random] { return static_cast<std::uint8_t>(random()); }); break;
        case 2: bytes.erase(first, last); break;
        case 3: bytes.resize(from); break;
        default: {
          const Bytes copy(first, last);
          bytes.insert(bytes.begin() + static_cast<std::ptrdiff_t>(random() % bytes.size()), copy.begin(), copy.end());
          moved = true;
        }
      }
    }
    check_never_wrong(id, bytes);
    if (!moved) check_salvage(id, bytes);  // a whole block that stands twice is saved twice
  }
}

void test_salvage_keeps_the_rest() {
  Bytes bytes = whole().bytes;
  bytes[heads()[4] + 20] ^= 1;
  bytes[heads()[8] + 1] ^= 1;
  const host::DeviceLog log = parsed(bytes, host::Damaged::leave_out);
  TEST_ASSERT_EQUAL_INT(2, log.notes.size());
  const host::LogBlocks blocks = host::find_blocks(bytes);
  TEST_ASSERT_EQUAL_INT(heads().size() - 2, blocks.blocks.size());
  check_salvage(Id().add("case", "two blocks"), bytes);
}

}  // namespace

int main(int argc, char** argv) {
  test::select_cases(argc, argv);
  UNITY_BEGIN();
  RUN_TEST(test_torn_at_every_byte);
  RUN_TEST(test_torn_into_erased_flash);
  RUN_TEST(test_damage_is_named);
  RUN_TEST(test_whole_blocks_with_wrong_content_are_refused);
  RUN_TEST(test_every_bit);
  RUN_TEST(test_random_damage);
  RUN_TEST(test_salvage_keeps_the_rest);
  return UNITY_END();
}
