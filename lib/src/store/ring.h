// An append-only ring of states over erase blocks (docs/storage.md). A state is a set of records that counts as a whole
// from the moment when its last page, the commit, is programmed; it has its erase blocks for itself, and no byte of the
// newest whole state is touched until the next one is whole.
#pragma once

#include "math/resumable.h"
#include "store/flash.h"

namespace SEGCAL_NS {

/// What a save writes. Blocks may turn out to be bad: any part may be asked for again.
struct RecordSource {
  void* context;
  std::uint32_t count;  ///< records
  RecordInfo (*info)(void* context, std::uint32_t number);
  void (*read)(void* context, std::uint32_t number, std::uint32_t offset, std::uint8_t* to, std::uint32_t n);
  bool (*unchanged)(void* context);  ///< what was read is still so
};

/// Who takes what is found. SEGCAL_OK to go on; an error ends the search with that answer; kNotThis: this state cannot
/// be used, look for an older one. Until `end` has been called nothing of it may count.
struct RecordSink {
  static constexpr int kNotThis = 1;
  void* context;
  void (*begin)(void* context);  ///< of a state, the first record follows
  int (*record)(void* context, const RecordInfo& record);
  int (*bytes)(void* context, std::uint32_t offset, const std::uint8_t* bytes, std::uint32_t n);
  int (*close)(void* context);  ///< the record's checksum is right
  int (*end)(void* context);    ///< the state is whole
};

class Ring {
 public:
  /// All begin work that step() does.
  void open(const segcal_flash_t& flash);
  /// Looks for the newest whole state; without a sink only to know where it is.
  void look(const RecordSink* sink);
  /// What `source` points to must stay until it is done.
  void save(const RecordSource& source);
  /// One slice. True when all is done.
  bool step();
  bool busy() const { return work_ != Work::nothing; }
  /// Of what was done last: SEGCAL_OK, SEGCAL_EMPTY, or an error.
  int answer() const { return answer_; }
  /// Whether it is known where the newest whole state is: else nothing can be saved.
  bool known() const { return known_; }
  void fill(segcal_store_info_t* info) const;

 private:
  static constexpr std::uint32_t kNone = 0xFFFFFFFFu;
  static constexpr int kReadings = 3;  ///< of a state that does not check: bits can be misread
  enum class Work : std::int32_t { nothing, looking, saving };
  /// Where a record's bytes stand.
  struct Cursor {
    std::uint32_t number, at;  ///< `at`: from the record's head
    Crc32 crc;                 ///< of its bytes so far
    Crc32 chain;               ///< of the checksums of the records before
  };

  // ring_look.cpp
  bool look_step();
  bool walk_step();
  bool next_page_step();
  bool next_block_step();
  void note_heads_begin();
  void note_head();
  bool read_head(std::uint32_t block, BlockHead* head);
  bool take_record_head();
  void take_bytes();
  bool ask(int sink_answer);
  // ring_save.cpp
  bool save_step();
  bool write_step();
  void begin_writing();
  void end_writing();
  bool take_block_step();
  std::uint32_t blocks_needed() const;
  void fill_page();
  void put_bytes(const std::uint8_t* bytes, std::uint32_t from, std::uint32_t n, std::uint32_t* i);
  bool works(FlashAnswer answer);
  /// Blocks from `block` to the newest whole state.
  std::uint32_t room_from(std::uint32_t block) const {
    return live_blocks_ == 0 ? flash_.blocks() : (live_first_ + flash_.blocks() - block) % flash_.blocks();
  }
  std::uint32_t free_first() const {
    return live_blocks_ == 0 ? next_ : (live_first_ + live_blocks_) % flash_.blocks();
  }

  Flash flash_;
  RecordSource source_;
  RecordSink sink_;
  Work work_ = Work::nothing;
  Place place_ = 0, walk_place_ = 0, page_place_ = 0, block_place_ = 0;
  std::int32_t answer_ = 0, error_ = 0;
  bool known_ = false, has_sink_ = false;

  // The newest whole state: a stretch of the ring.
  std::uint32_t live_first_ = 0, live_blocks_ = 0, live_generation_ = 0;
  std::uint32_t newest_ = 0;  ///< generation of the newest head of all
  std::uint32_t next_ = 0;    ///< block that is taken next
  BlockHead live_head_;       ///< any of its blocks'; of a newer format if that was found

  // Where the work stands.
  std::uint32_t limit_, generation_, start_, start_taken_, furthest_taken_, b_, attempt_;
  std::uint32_t block_, page_, at_place_, best_, taken_, needed_, available_;
  RecordInfo record_;
  Cursor cursor_, checkpoint_;
  bool whole_, page_ok_, newer_format_, retry_, from_start_;
  std::uint32_t passed_over_ = 0, bad_blocks_ = 0;
  std::uint8_t tail_[kRecordTailBytes];
  std::uint8_t buffer_[SEGCAL_STORE_PAGE_MAX];
};

}  // namespace SEGCAL_NS
