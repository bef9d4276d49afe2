// The platform's flash in pages: what is programmed is read back, since a worn cell does not say so.
#pragma once

#include <cstring>

#include "store/format.h"

namespace SEGCAL_NS {

enum class FlashAnswer : std::int32_t { ok, bad, failed };

class Flash {
 public:
  static bool valid(const segcal_flash_t& f) {
    const std::uint32_t p = f.program_bytes;
    return f.read && f.program && f.erase && f.sync && p >= 1 && p <= SEGCAL_STORE_PAGE_MAX && (p & (p - 1)) == 0 &&
           f.erase_bytes >= 512 && f.erase_bytes <= 1u << 24 && f.erase_bytes % SEGCAL_STORE_PAGE_MAX == 0 &&
           f.blocks >= 2 && f.blocks <= 65535;
  }
  void begin(const segcal_flash_t& flash) {
    flash_ = flash;
    erases = programs = 0;
  }
  std::uint32_t blocks() const { return flash_.blocks; }
  std::uint32_t erase_bytes() const { return flash_.erase_bytes; }
  std::uint32_t page_bytes() const { return flash_.program_bytes < kLeastPage ? kLeastPage : flash_.program_bytes; }
  std::uint32_t pages() const { return flash_.erase_bytes / page_bytes(); }  ///< of a block

  FlashAnswer read(std::uint32_t block, std::uint32_t page, std::uint8_t* to, std::uint32_t n) {
    return answer(flash_.read(flash_.context, block, page * page_bytes(), to, n));
  }
  FlashAnswer erase(std::uint32_t block) {
    ++erases;
    return answer(flash_.erase(flash_.context, block));
  }
  FlashAnswer program(std::uint32_t block, std::uint32_t page, const std::uint8_t* from) {
    ++programs;
    const FlashAnswer programmed =
        answer(flash_.program(flash_.context, block, page * page_bytes(), from, page_bytes()));
    return programmed == FlashAnswer::ok ? compare(block, page, from) : programmed;
  }
  FlashAnswer sync() { return flash_.sync(flash_.context) == 0 ? FlashAnswer::ok : FlashAnswer::failed; }

  std::uint32_t erases = 0, programs = 0;

 private:
  static FlashAnswer answer(int code) {
    return code == 0 ? FlashAnswer::ok : code == SEGCAL_FLASH_BAD ? FlashAnswer::bad : FlashAnswer::failed;
  }
  FlashAnswer compare(std::uint32_t block, std::uint32_t page, const std::uint8_t* expected) {
    std::uint8_t part[kLeastPage];
    for (std::uint32_t at = 0; at < page_bytes(); at += kLeastPage) {
      const FlashAnswer got = answer(flash_.read(flash_.context, block, page * page_bytes() + at, part, kLeastPage));
      if (got != FlashAnswer::ok) return got;
      if (std::memcmp(part, expected + at, kLeastPage) != 0) return FlashAnswer::bad;
    }
    return FlashAnswer::ok;
  }
  segcal_flash_t flash_;
};

}  // namespace SEGCAL_NS
