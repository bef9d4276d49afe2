// Ring: finding the newest whole state (docs/storage.md, "Looking").
#include "store/ring.h"

namespace SEGCAL_NS {

void Ring::open(const segcal_flash_t& flash) {
  flash_.begin(flash);
  live_first_ = live_blocks_ = live_generation_ = newest_ = next_ = 0;
  bad_blocks_ = passed_over_ = 0;
  live_head_ = BlockHead{};
  look(nullptr);
}

void Ring::look(const RecordSink* sink) {
  has_sink_ = sink != nullptr;
  if (sink) sink_ = *sink;
  work_ = Work::looking;
  known_ = false;
  error_ = 0;
  place_ = walk_place_ = page_place_ = block_place_ = 0;
}

bool Ring::step() {
  if (work_ == Work::nothing) return true;
  if (!(work_ == Work::looking ? look_step() : save_step())) return false;
  if (error_ != 0) answer_ = error_;
  work_ = Work::nothing;
  return true;
}

void Ring::fill(segcal_store_info_t* info) const {
  info->ready = known_ && !busy() ? 1 : 0;
  info->generation = live_generation_;
  info->blocks = live_blocks_;
  info->passed_over = passed_over_;
  info->bad_blocks = bad_blocks_;
  info->erases = flash_.erases;
  info->programs = flash_.programs;
  info->library_version = live_head_.library_version;
  info->format_major = live_head_.major;
  info->format_minor = live_head_.minor;
}

/// False if there is no head of ours, or the medium failed (error_).
bool Ring::read_head(std::uint32_t block, BlockHead* head) {
  std::uint8_t bytes[kBlockHeadBytes];
  const FlashAnswer got = flash_.read(block, 0, bytes, kBlockHeadBytes);
  if (got == FlashAnswer::failed) error_ = SEGCAL_ERROR_STORAGE;
  if (got != FlashAnswer::ok || !decode(bytes, head)) return false;
  if (head->major > SEGCAL_STORE_MAJOR) {
    newer_format_ = true;
    live_head_ = *head;
    return false;
  }
  return head->erase_bytes == flash_.erase_bytes() && head->page_bytes == flash_.page_bytes();
}

void Ring::note_heads_begin() {
  generation_ = 0;
  start_ = kNone;
  start_taken_ = furthest_taken_ = 0;
  newer_format_ = false;
}

/// The newest generation up to limit_, and where it begins: a
/// block that failed was taken before the one that replaced it.
void Ring::note_head() {
  BlockHead head;
  if (!read_head(b_, &head) || head.generation > limit_ || head.generation < generation_) return;
  if (head.generation > generation_) {
    note_heads_begin();
    generation_ = head.generation;
  }
  if (head.place == 0 && (start_ == kNone || head.taken >= start_taken_)) {
    start_ = b_;
    start_taken_ = head.taken;
  }
  if (limit_ == kNone && head.taken >= furthest_taken_) {
    furthest_taken_ = head.taken;
    next_ = (b_ + 1) % flash_.blocks();
  }
}

bool Ring::look_step() {
  SEGCAL_SLICES(place_) {
    passed_over_ = 0;
    live_blocks_ = live_generation_ = 0;
    for (limit_ = kNone;; limit_ = generation_ - 1, ++passed_over_) {
      note_heads_begin();
      for (b_ = 0; b_ < flash_.blocks() && error_ == 0; ++b_) {
        note_head();
        if (newer_format_) error_ = SEGCAL_ERROR_VERSION;
        SEGCAL_PAUSE(place_);
      }
      if (limit_ == kNone) newest_ = generation_;
      if (error_ != 0 || generation_ == 0) break;
      whole_ = false;
      for (attempt_ = 0; attempt_ < kReadings && !whole_ && error_ == 0; ++attempt_) SEGCAL_AWAIT(place_, walk_step());
      if (whole_ || error_ != 0) break;
    }
    answer_ = generation_ == 0 ? SEGCAL_EMPTY : SEGCAL_OK;
    known_ = error_ == 0;
  }
  SEGCAL_SLICES_END(place_);
}

/// Reads state generation_ from its first page to its commit; whole_ says whether it is.
bool Ring::walk_step() {
  SEGCAL_SLICES(walk_place_) {
    whole_ = false;
    page_ok_ = start_ != kNone;
    block_ = start_;
    at_place_ = 0;
    page_ = 1;
    cursor_ = Cursor{};
    if (has_sink_ && page_ok_) sink_.begin(sink_.context);
    while (page_ok_ && !whole_) {
      SEGCAL_AWAIT(walk_place_, next_page_step());
      if (!page_ok_ || !take_record_head() || record_.type == kCommitType) break;
      take_bytes();
      while (page_ok_ && cursor_.at < kRecordHeadBytes + record_.bytes + kRecordTailBytes) {
        SEGCAL_AWAIT(walk_place_, next_page_step());
        take_bytes();
      }
      ++cursor_.number;
    }
  }
  SEGCAL_SLICES_END(walk_place_);
}

/// The page that follows, into buffer_; page_ok_ says whether there is one.
bool Ring::next_page_step() {
  SEGCAL_SLICES(page_place_) {
    if (page_ == flash_.pages()) {
      SEGCAL_AWAIT(page_place_, next_block_step());
      page_ok_ = best_ != kNone;
      block_ = best_;
      page_ = 1;
      ++at_place_;
    }
    if (page_ok_) {
      const FlashAnswer got = flash_.read(block_, page_, buffer_, flash_.page_bytes());
      if (got == FlashAnswer::failed) error_ = SEGCAL_ERROR_STORAGE;
      page_ok_ = got == FlashAnswer::ok;
      ++page_;
    }
    SEGCAL_PAUSE(page_place_);
  }
  SEGCAL_SLICES_END(page_place_);
}

/// The block at the next place, into best_. Where one failed, the
/// block that replaced it is further on: the last one counts.
bool Ring::next_block_step() {
  SEGCAL_SLICES(block_place_) {
    best_ = kNone;
    for (b_ = 1; b_ < flash_.blocks() && error_ == 0; ++b_) {
      BlockHead head;
      if (read_head((block_ + b_) % flash_.blocks(), &head) && head.generation == generation_) {
        if (head.place != at_place_ + 1) break;
        best_ = (block_ + b_) % flash_.blocks();
      }
      SEGCAL_PAUSE(block_place_);
    }
  }
  SEGCAL_SLICES_END(block_place_);
}

/// True if the sink goes on.
bool Ring::ask(int sink_answer) {
  if (sink_answer < 0) error_ = sink_answer;
  page_ok_ = page_ok_ && sink_answer == SEGCAL_OK;
  return page_ok_;
}

/// At a record's first page. False if it is none, or the sink has enough. A commit that is right makes the state whole.
bool Ring::take_record_head() {
  cursor_.at = kRecordHeadBytes;
  cursor_.crc = Crc32{};
  if (!decode(buffer_, generation_, cursor_.number, &record_)) return false;
  if (record_.type != kCommitType) return !has_sink_ || ask(sink_.record(sink_.context, record_));
  Crc32 crc;
  crc.add(buffer_ + kRecordHeadBytes, kCommitBytes);
  ByteReader tail(buffer_ + kRecordHeadBytes + kCommitBytes, kRecordTailBytes);
  const Commit expected = {cursor_.number, at_place_ + 1, cursor_.chain.value()};
  if (record_.bytes != kCommitBytes || tail.integer<std::uint32_t>() != crc.value()) return false;
  if (!(decode_commit(buffer_ + kRecordHeadBytes) == expected)) return false;
  if (has_sink_ && !ask(sink_.end(sink_.context))) return false;
  whole_ = true;
  live_first_ = start_;
  live_blocks_ = (block_ + flash_.blocks() - start_) % flash_.blocks() + 1;
  live_generation_ = generation_;
  BlockHead head;
  if (read_head(start_, &head)) live_head_ = head;
  return true;
}

/// What buffer_ holds of the record: bytes to the sink, then the checksum.
void Ring::take_bytes() {
  if (!page_ok_) return;
  const std::uint32_t n = flash_.page_bytes(), end = kRecordHeadBytes + record_.bytes;
  std::uint32_t i = cursor_.at % n;  // records begin where pages do
  if (cursor_.at < end) {
    const std::uint32_t left = end - cursor_.at, here = left < n - i ? left : n - i;
    cursor_.crc.add(buffer_ + i, here);
    if (has_sink_ && !ask(sink_.bytes(sink_.context, cursor_.at - kRecordHeadBytes, buffer_ + i, here))) return;
    i += here;
    cursor_.at += here;
  }
  for (; i < n && cursor_.at >= end && cursor_.at < end + kRecordTailBytes; ++i, ++cursor_.at) {
    tail_[cursor_.at - end] = buffer_[i];
  }
  if (cursor_.at < end + kRecordTailBytes) return;
  page_ok_ = ByteReader(tail_, kRecordTailBytes).integer<std::uint32_t>() == cursor_.crc.value();
  cursor_.chain.add(tail_, kRecordTailBytes);
  if (page_ok_ && has_sink_) ask(sink_.close(sink_.context));
}

}  // namespace SEGCAL_NS
