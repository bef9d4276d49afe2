// The framing of a device log: where its blocks are, and whether each is as it was written.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace host {

/// A block whose CRCs are right.
struct LogBlockView {
  std::uint16_t type = 0;
  std::size_t offset = 0;  ///< of its head in the file
  const std::uint8_t* payload = nullptr;
  std::size_t size = 0;
};

/// A stretch that is not as it was written.
struct LogDamage {
  std::size_t offset = 0, bytes = 0;
  std::string found;  ///< what was expected there and what is there
};

struct LogBlocks {
  std::vector<LogBlockView> blocks;
  std::vector<LogDamage> damage;  ///< in the middle: bits are wrong or blocks are missing
  LogDamage torn;                 ///< at the end, bytes > 0: a last block that the device did not get to finish
  bool ended = false;             ///< the device closed the log; what follows in the file is not of it
};

/// `bytes` must outlive the result. Never throws: all that is wrong is in the result.
LogBlocks find_blocks(const std::vector<std::uint8_t>& bytes);

}  // namespace host
