// Ring: writing a state (docs/storage.md, "Saving").
#include "store/ring.h"

namespace SEGCAL_NS {

void Ring::save(const RecordSource& source) {
  source_ = source;
  work_ = Work::saving;
  error_ = 0;
  place_ = walk_place_ = page_place_ = block_place_ = 0;
}

/// A state's bytes, commit included, in blocks.
std::uint32_t Ring::blocks_needed() const {
  const std::uint32_t page = flash_.page_bytes();
  std::uint32_t pages = 1;
  for (std::uint32_t i = 0; i < source_.count; ++i) {
    pages += (kRecordHeadBytes + source_.info(source_.context, i).bytes + kRecordTailBytes + page - 1) / page;
  }
  const std::uint32_t of_block = flash_.pages() - 1;
  return (pages + of_block - 1) / of_block;
}

/// False if the medium cannot be reached any more (error_), or this block is no good.
bool Ring::works(FlashAnswer answer) {
  if (answer == FlashAnswer::failed) error_ = SEGCAL_ERROR_STORAGE;
  if (answer == FlashAnswer::bad) ++bad_blocks_;
  return answer == FlashAnswer::ok;
}

bool Ring::save_step() {
  SEGCAL_SLICES(place_) {
    needed_ = blocks_needed();
    if (needed_ > flash_.blocks() - live_blocks_ || newest_ >= kLastGeneration - 1) error_ = SEGCAL_ERROR_FULL;
    while (error_ == 0) {
      begin_writing();
      SEGCAL_AWAIT(place_, write_step());
      if (error_ == 0) end_writing();
      // With bad blocks the stretch may have been too short: then once more with all that is free.
      if (error_ != SEGCAL_ERROR_FULL || from_start_) break;
      error_ = 0;
      next_ = free_first();
    }
    answer_ = SEGCAL_OK;
  }
  SEGCAL_SLICES_END(place_);
}

/// A state lies in one stretch, so that what is free beside it is one stretch too: from where the last one ended if
/// that leaves room, else from the beginning of what is free.
void Ring::begin_writing() {
  if (room_from(next_) < needed_) next_ = free_first();
  from_start_ = next_ == free_first();
  available_ = room_from(next_);
  generation_ = ++newest_;
  taken_ = at_place_ = 0;
  page_ = flash_.pages();
  cursor_ = Cursor{};
  retry_ = true;  // the first block is at place 0
}

bool Ring::write_step() {
  SEGCAL_SLICES(walk_place_) {
    while (error_ == 0 && cursor_.number <= source_.count) {
      if (page_ == flash_.pages()) {
        if (!retry_) ++at_place_;
        retry_ = false;
        SEGCAL_AWAIT(walk_place_, take_block_step());
        if (error_ != 0) break;
        checkpoint_ = cursor_;
      }
      if (!source_.unchanged(source_.context)) {
        error_ = SEGCAL_ERROR_BUSY;
        break;
      }
      if (cursor_.number == source_.count) {
        // All that the commit speaks for must be on the medium before it.
        if (!works(flash_.sync())) break;
        SEGCAL_PAUSE(walk_place_);
      }
      fill_page();
      if (works(flash_.program(block_, page_, buffer_))) {
        ++page_;
      } else {
        cursor_ = checkpoint_;  // what this block was to hold goes to the next one
        page_ = flash_.pages();
        retry_ = true;
      }
      SEGCAL_PAUSE(walk_place_);
    }
    if (error_ == 0) works(flash_.sync());
  }
  SEGCAL_SLICES_END(walk_place_);
}

void Ring::end_writing() {
  live_blocks_ = (block_ + flash_.blocks() - start_) % flash_.blocks() + 1;
  live_first_ = start_;
  live_generation_ = generation_;
  live_head_ = BlockHead{generation_, 0, 0, 0, 0, SEGCAL_VERSION, SEGCAL_STORE_MAJOR, SEGCAL_STORE_MINOR};
}

/// The next good block of the stretch, erased, with its head.
bool Ring::take_block_step() {
  SEGCAL_SLICES(block_place_) {
    for (page_ = 0; page_ == 0;) {
      if (taken_ == available_) {
        error_ = SEGCAL_ERROR_FULL;
        break;
      }
      block_ = next_;
      next_ = (block_ + 1) % flash_.blocks();
      ++taken_;
      best_ = works(flash_.erase(block_)) ? block_ : kNone;
      SEGCAL_PAUSE(block_place_);
      if (best_ != kNone) {
        std::memset(buffer_, 0xFF, sizeof buffer_);
        encode({generation_, static_cast<std::uint16_t>(at_place_), static_cast<std::uint16_t>(taken_ - 1),
                flash_.erase_bytes(), flash_.page_bytes(), SEGCAL_VERSION, SEGCAL_STORE_MAJOR, SEGCAL_STORE_MINOR},
               buffer_);
        if (works(flash_.program(block_, 0, buffer_))) page_ = 1;
        SEGCAL_PAUSE(block_place_);
      }
      if (error_ != 0) break;
    }
    if (at_place_ == 0) start_ = block_;
  }
  SEGCAL_SLICES_END(block_place_);
}

/// `n` bytes that stand `from` bytes behind the record's head, as far as the page at *i and the cursor reach.
void Ring::put_bytes(const std::uint8_t* bytes, std::uint32_t from, std::uint32_t n, std::uint32_t* i) {
  while (*i < flash_.page_bytes() && cursor_.at >= from && cursor_.at < from + n)
    buffer_[(*i)++] = bytes[cursor_.at++ - from];
}

/// The next page of the record under way; behind the last record, the commit.
void Ring::fill_page() {
  std::memset(buffer_, 0xFF, sizeof buffer_);
  const bool commit = cursor_.number == source_.count;
  const RecordInfo record =
      commit ? RecordInfo{kCommitType, 0, kCommitBytes} : source_.info(source_.context, cursor_.number);
  const std::uint32_t n = flash_.page_bytes(), end = kRecordHeadBytes + record.bytes;
  std::uint8_t part[kRecordHeadBytes];
  std::uint32_t i = 0;
  encode(record, generation_, cursor_.number, part);
  put_bytes(part, 0, kRecordHeadBytes, &i);
  if (i < n && cursor_.at < end) {
    const std::uint32_t left = end - cursor_.at, here = left < n - i ? left : n - i;
    if (commit) {
      encode(Commit{cursor_.number, at_place_ + 1, cursor_.chain.value()}, buffer_ + i);
    } else {
      source_.read(source_.context, cursor_.number, cursor_.at - kRecordHeadBytes, buffer_ + i, here);
    }
    cursor_.crc.add(buffer_ + i, here);
    i += here;
    cursor_.at += here;
  }
  ByteWriter(part, kRecordTailBytes).integer(cursor_.crc.value());
  put_bytes(part, end, kRecordTailBytes, &i);
  if (cursor_.at < end + kRecordTailBytes) return;
  cursor_.chain.add(part, kRecordTailBytes);
  cursor_.crc = Crc32{};
  cursor_.at = 0;
  ++cursor_.number;
}

}  // namespace SEGCAL_NS
