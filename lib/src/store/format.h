// Bytes of the store (docs/storage.md): what stands at the head of a block and of a record.
#pragma once

#include "math/bytes.h"
#include "segcal/store.h"

namespace SEGCAL_NS {

constexpr std::uint32_t kStoreMagic = 0x54534353u;  ///< "SCST"
constexpr int kBlockHeadBytes = 32, kRecordHeadBytes = 20, kRecordTailBytes = 4, kCommitBytes = 12;
constexpr std::uint16_t kCommitType = 0xFFFFu;
/// Everything is written in pages of at least this, so that either head fits into one.
constexpr std::uint32_t kLeastPage = 64;
constexpr std::uint32_t kLastGeneration = 0xFFFFFFF0u;  ///< one save a second reaches it after 136 years
constexpr std::uint32_t kMostRecordBytes = 1u << 28;

/// First page of a block that was taken for a state.
struct BlockHead {
  std::uint32_t generation;  ///< of the state, from 1
  std::uint16_t place;       ///< of this block in the state's bytes, from 0
  std::uint16_t taken;       ///< blocks taken before it for the same state, unusable ones included
  std::uint32_t erase_bytes;
  std::uint32_t page_bytes;
  std::uint32_t library_version;
  std::uint16_t major, minor;
};

inline void encode(const BlockHead& head, std::uint8_t* bytes) {
  ByteWriter out(bytes, kBlockHeadBytes);
  out.integer(kStoreMagic);
  out.integer(head.major);
  out.integer(head.minor);
  out.integer(head.library_version);
  out.integer(head.generation);
  out.integer(head.place);
  out.integer(head.taken);
  out.integer(head.erase_bytes);
  out.integer(head.page_bytes);
  out.integer(crc32(bytes, out.size()));
}

/// False if the bytes are no head, of any format: magic, versions
/// and the checksum stand at the same place in all of them.
inline bool decode(const std::uint8_t* bytes, BlockHead* head) {
  ByteReader in(bytes, kBlockHeadBytes);
  if (in.integer<std::uint32_t>() != kStoreMagic) return false;
  head->major = in.integer<std::uint16_t>();
  head->minor = in.integer<std::uint16_t>();
  head->library_version = in.integer<std::uint32_t>();
  head->generation = in.integer<std::uint32_t>();
  head->place = in.integer<std::uint16_t>();
  head->taken = in.integer<std::uint16_t>();
  head->erase_bytes = in.integer<std::uint32_t>();
  head->page_bytes = in.integer<std::uint32_t>();
  const bool numbered = head->generation != 0 && head->generation <= kLastGeneration;
  return in.integer<std::uint32_t>() == crc32(bytes, kBlockHeadBytes - 4) && numbered;
}

/// What a record is; its bytes mean something to who wrote it only.
struct RecordInfo {
  std::uint16_t type, index;
  std::uint32_t bytes;
};

/// `number`: of the record in its state, from 0.
inline void encode(const RecordInfo& record, std::uint32_t generation, std::uint32_t number, std::uint8_t* bytes) {
  ByteWriter out(bytes, kRecordHeadBytes);
  out.integer(record.type);
  out.integer(record.index);
  out.integer(record.bytes);
  out.integer(generation);
  out.integer(number);
  out.integer(crc32(bytes, out.size()));
}

inline bool decode(const std::uint8_t* bytes, std::uint32_t generation, std::uint32_t number, RecordInfo* record) {
  ByteReader in(bytes, kRecordHeadBytes);
  record->type = in.integer<std::uint16_t>();
  record->index = in.integer<std::uint16_t>();
  record->bytes = in.integer<std::uint32_t>();
  const bool here = in.integer<std::uint32_t>() == generation && in.integer<std::uint32_t>() == number;
  return here && record->bytes <= kMostRecordBytes && in.integer<std::uint32_t>() == crc32(bytes, kRecordHeadBytes - 4);
}

/// The last record: what makes those before it count.
struct Commit {
  std::uint32_t records, blocks;
  std::uint32_t check;  ///< CRC-32 over the checksums of all records' bytes, in order
};

inline void encode(const Commit& commit, std::uint8_t* bytes) {
  ByteWriter out(bytes, kCommitBytes);
  out.integer(commit.records);
  out.integer(commit.blocks);
  out.integer(commit.check);
}

inline bool operator==(const Commit& a, const Commit& b) {
  return a.records == b.records && a.blocks == b.blocks && a.check == b.check;
}

inline Commit decode_commit(const std::uint8_t* bytes) {
  ByteReader in(bytes, kCommitBytes);
  Commit commit;
  commit.records = in.integer<std::uint32_t>();
  commit.blocks = in.integer<std::uint32_t>();
  commit.check = in.integer<std::uint32_t>();
  return commit;
}

}  // namespace SEGCAL_NS
