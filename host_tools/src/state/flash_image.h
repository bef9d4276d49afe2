// Flash of a device's store (segcal/store.h) in memory, as bytes
// that a file can hold: blocks of 4 KiB, erased ones 0xFF.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "segcal/store.h"

namespace host {

struct FlashImage {
  static constexpr std::uint32_t kProgramBytes = 256, kEraseBytes = 4096;

  std::string bytes;  ///< a multiple of kEraseBytes; empty: no flash yet

  void make(std::uint32_t blocks) { bytes.assign(std::size_t(blocks) * kEraseBytes, '\xFF'); }
  /// A page as a store writes it, behind page `last` (-1: the first): the next one, or the next block's first. False,
  /// and nothing is changed, for another one. `last` becomes this one.
  bool append(std::uint32_t block, std::uint32_t offset, std::string_view page, std::int64_t* last);
  /// What segcal_store_open takes. The image must stay where it is.
  segcal_flash_t port();
};

}  // namespace host
