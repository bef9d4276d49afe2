// A block of a device log on its way out: what the functions of segcal/log.h share.
#pragma once

#include "log/format.h"

namespace SEGCAL_NS {

/// The block's payload begins behind its head.
inline ByteWriter payload_of(const segcal_log_t& log) {
  return ByteWriter(log.block + kBlockHead, log.capacity - kBlockHead - kBlockTail);
}

inline int write(segcal_log_t* log, const std::uint8_t* bytes, std::size_t n) {
  if (log->failed) return SEGCAL_ERROR_STATE;
  log->failed = log->write(log->context, bytes, n) == 0 ? 0 : 1;
  return log->failed ? SEGCAL_ERROR_STATE : SEGCAL_OK;
}

/// Head and CRCs around a payload of n bytes that is in place, and out with it.
inline int write_block(segcal_log_t* log, LogBlock type, std::size_t n) {
  ByteWriter head(log->block, kBlockHead);
  head.integer(kBlockMark);
  head.integer(static_cast<std::uint16_t>(type));
  head.integer(static_cast<std::uint16_t>(log->sequence++));
  head.integer(static_cast<std::uint32_t>(n));
  head.integer(crc32(log->block, head.size()));
  ByteWriter tail(log->block + kBlockHead + n, kBlockTail);
  tail.integer(crc32(log->block + kBlockHead, n));
  log->used = 0;
  log->samples = 0;
  return write(log, log->block, kBlockHead + n + kBlockTail);
}

/// The samples that wait go out.
inline int finish_samples(segcal_log_t* log) {
  if (log->samples == 0) return log->failed ? SEGCAL_ERROR_STATE : SEGCAL_OK;
  ByteWriter head(log->block + kBlockHead, kImuHead);
  head.integer(log->t0_ns);
  head.integer(log->samples);
  return write_block(log, LogBlock::imu, log->used);
}

/// What begins a block of another kind.
inline int start(segcal_log_t* log) { return !log || !log->write ? SEGCAL_ERROR_NULL : finish_samples(log); }

}  // namespace SEGCAL_NS
