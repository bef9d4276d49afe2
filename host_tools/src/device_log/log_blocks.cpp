#include "device_log/log_blocks.h"

#include <cstdio>
#include <cstring>

#include "log/format.h"

namespace host {
namespace {

using namespace SEGCAL_NS;

std::string hex(std::uint64_t value) {
  char text[24];
  std::snprintf(text, sizeof text, "0x%08llx", static_cast<unsigned long long>(value));
  return text;
}

/// What a head says; `ok`: its mark and CRC are right.
struct Head {
  bool ok = false;
  std::uint16_t type = 0, sequence = 0;
  std::size_t size = 0;
  std::uint32_t crc = 0, computed = 0;
};

Head head_at(const std::vector<std::uint8_t>& bytes, std::size_t offset) {
  Head head;
  ByteReader in(bytes.data() + offset, kBlockHead);
  const bool marked = in.integer<std::uint32_t>() == kBlockMark;
  head.type = in.integer<std::uint16_t>();
  head.sequence = in.integer<std::uint16_t>();
  head.size = in.integer<std::uint32_t>();
  head.crc = in.integer<std::uint32_t>();
  head.computed = crc32(bytes.data() + offset, kBlockHead - 4);
  head.ok = marked && head.crc == head.computed;
  return head;
}

/// The next place after `offset` with a whole head; the end of the file if there is none.
std::size_t next_head(const std::vector<std::uint8_t>& bytes, std::size_t offset) {
  for (++offset; offset + kBlockHead <= bytes.size(); ++offset) {
    if (bytes[offset] == (kBlockMark & 0xFF) && head_at(bytes, offset).ok) return offset;
  }
  return bytes.size();
}

class Scan {
 public:
  explicit Scan(const std::vector<std::uint8_t>& bytes) : bytes_(bytes) {}

  LogBlocks run() {
    if (bytes_.size() < kLogMagicBytes || std::memcmp(bytes_.data(), kLogMagic, kLogMagicBytes) != 0) {
      out_.damage.push_back({0, bytes_.size(), "expected the eight bytes that a device log begins with, found others"});
      return out_;
    }
    at_ = kLogMagicBytes;
    while (at_ < bytes_.size() && !out_.ended) step();
    take_off_torn_end();
    return out_;
  }

 private:
  /// Damage after which nothing whole follows: power went while this was written, whatever stands there now.
  void take_off_torn_end() {
    std::size_t end = bytes_.size();
    while (!out_.damage.empty() && out_.damage.back().bytes > 0 &&
           out_.damage.back().offset + out_.damage.back().bytes == end) {
      out_.torn = out_.damage.back();
      end = out_.torn.offset;
      out_.torn.bytes = bytes_.size() - end;
      out_.damage.pop_back();
    }
  }

  void step() {
    const std::size_t left = bytes_.size() - at_;
    if (left < kBlockHead) return skip(left, "expected the 16 bytes of a block's head, found " + std::to_string(left));
    const Head head = head_at(bytes_, at_);
    const std::size_t all = kBlockHead + head.size + kBlockTail;
    if (!head.ok) {
      skip(next_head(bytes_, at_) - at_,
           "expected the head of a block with CRC " + hex(head.computed) + ", found " + hex(head.crc));
    } else if (left < all) {
      skip(left, "expected a block of " + std::to_string(all) + " bytes, found " + std::to_string(left));
    } else {
      take(head, all);
    }
  }

  void take(const Head& head, std::size_t all) {
    const std::uint8_t* payload = bytes_.data() + at_ + kBlockHead;
    const std::uint32_t expected = ByteReader(payload + head.size, kBlockTail).integer<std::uint32_t>();
    const std::uint32_t found = crc32(payload, head.size);
    if (head.sequence != sequence_ && !after_damage_) {  // else the gap is that of the stretch left out
      out_.damage.push_back(
          {at_, 0, "expected block " + std::to_string(sequence_) + ", found block " + std::to_string(head.sequence)});
    }
    sequence_ = static_cast<std::uint16_t>(head.sequence + 1);
    after_damage_ = false;
    if (found != expected) {
      return skip(all, "expected CRC " + hex(expected) + " of a block of " + std::to_string(head.size) +
                           " bytes, found " + hex(found));
    }
    out_.blocks.push_back({head.type, at_, payload, head.size});
    out_.ended = head.type == static_cast<std::uint16_t>(LogBlock::end);
    at_ += all;
  }

  void skip(std::size_t bytes, const std::string& found) {
    out_.damage.push_back({at_, bytes, found});
    after_damage_ = true;
    at_ += bytes;
  }

  const std::vector<std::uint8_t>& bytes_;
  LogBlocks out_;
  std::size_t at_ = 0;
  std::uint16_t sequence_ = 0;
  bool after_damage_ = false;
};

}  // namespace

LogBlocks find_blocks(const std::vector<std::uint8_t>& bytes) { return Scan(bytes).run(); }

}  // namespace host
