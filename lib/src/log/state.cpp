// A device's state at the beginning of its log: the flash that the store writes it to (segcal/log.h).
#include <cstring>

#include "log/block_writer.h"
#include "segcal/storage.h"

namespace SEGCAL_NS {
namespace {

/// Blocks for a state at its largest: all of the device's memory, and one head in each block.
constexpr std::uint32_t kStateBlocks = SEGCAL_STORAGE_BYTES / (kStateEraseBytes - kStateProgramBytes) + 2;

segcal_log_t* log_of(void* context) { return static_cast<segcal_log_t*>(context); }

bool takes_state(const segcal_log_t& log) { return !log.failed && log.awaits_state; }

int program(void* context, std::uint32_t block, std::uint32_t offset, const void* from, std::uint32_t n) {
  segcal_log_t* log = log_of(context);
  if (!takes_state(*log)) return -1;
  ByteWriter out = payload_of(*log);
  out.integer(block);
  out.integer(offset);
  const auto* bytes = static_cast<const std::uint8_t*>(from);
  for (std::uint32_t i = 0; i < n; ++i) out.integer(bytes[i]);
  if (!out.fits() || write_block(log, LogBlock::state, out.size()) != SEGCAL_OK) return -1;
  log->page_block = block;
  log->page_offset = offset;
  log->page_bytes = n;
  return 0;
}

/// The store reads back what it has just programmed, which the block still has.
int read(void* context, std::uint32_t block, std::uint32_t offset, void* to, std::uint32_t n) {
  const segcal_log_t& log = *log_of(context);
  const std::uint32_t from = offset - log.page_offset;  // wraps where it is before the page
  const bool last = log.page_bytes >= n && block == log.page_block && from <= log.page_bytes - n;
  if (last) {
    std::memcpy(to, log.block + kBlockHead + kStateHead + from, n);
  } else {
    std::memset(to, 0xFF, n);
  }
  return 0;
}

/// Each save begins with it.
int erase(void* context, std::uint32_t) {
  segcal_log_t* log = log_of(context);
  log->syncs = 0;
  return takes_state(*log) ? 0 : -1;
}

/// A save syncs before the page that makes its state whole, and after it (docs/storage.md, "Saving").
int sync(void* context) {
  segcal_log_t* log = log_of(context);
  if (!takes_state(*log)) return -1;
  if (++log->syncs == 2) log->awaits_state = 0;
  return 0;
}

}  // namespace
}  // namespace SEGCAL_NS

using namespace SEGCAL_NS;

extern "C" int segcal_log_state(segcal_log_t* log, const segcal_t* device, segcal_flash_t* flash) {
  segcal_progress_t progress;
  const int error = segcal_progress(device, &progress);
  if (!log || !log->write || !flash) return SEGCAL_ERROR_NULL;
  if (error != SEGCAL_OK) return error;
  segcal_state_t running;
  if (log->failed || log->fed || segcal_get_state(device, &running) == SEGCAL_OK) return SEGCAL_ERROR_STATE;
  log->awaits_state = 1;
  log->late = progress.late;  // what was late before is not in this log
  *flash = {log, kStateProgramBytes, kStateEraseBytes, kStateBlocks, read, program, erase, sync};
  return SEGCAL_OK;
}
