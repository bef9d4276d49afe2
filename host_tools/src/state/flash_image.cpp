#include "state/flash_image.h"

#include <algorithm>
#include <cstring>

namespace host {
namespace {

constexpr std::size_t kFewestBlocks = 2;  ///< of a flash (segcal_flash_t)

/// Where n bytes of a block begin; null: beyond the flash.
char* place(void* context, std::uint32_t block, std::uint32_t offset, std::uint32_t n) {
  std::string& bytes = static_cast<FlashImage*>(context)->bytes;
  const std::size_t at = std::size_t(block) * FlashImage::kEraseBytes + offset;
  return at + n <= bytes.size() ? bytes.data() + at : nullptr;
}

int read(void* context, std::uint32_t block, std::uint32_t offset, void* to, std::uint32_t n) {
  const char* from = place(context, block, offset, n);
  if (from) std::memcpy(to, from, n);
  return from ? 0 : -1;
}

int program(void* context, std::uint32_t block, std::uint32_t offset, const void* from, std::uint32_t n) {
  char* to = place(context, block, offset, n);
  if (to) std::memcpy(to, from, n);
  return to ? 0 : -1;
}

int erase(void* context, std::uint32_t block) {
  char* to = place(context, block, 0, FlashImage::kEraseBytes);
  if (to) std::memset(to, 0xFF, FlashImage::kEraseBytes);
  return to ? 0 : -1;
}

}  // namespace

bool FlashImage::append(std::uint32_t block, std::uint32_t offset, std::string_view page, std::int64_t* last) {
  constexpr std::int64_t pages = kEraseBytes / kProgramBytes;
  if (page.size() != kProgramBytes || offset % kProgramBytes != 0 || offset >= kEraseBytes) return false;
  const std::int64_t at = pages * block + offset / kProgramBytes, next = *last + 1;
  if (at != next && at != (next + pages - 1) / pages * pages) return false;
  const std::size_t blocks = std::max<std::size_t>(std::size_t(block) + 1, kFewestBlocks);
  if (bytes.size() < blocks * kEraseBytes) bytes.resize(blocks * kEraseBytes, '\xFF');
  std::memcpy(place(this, block, offset, kProgramBytes), page.data(), kProgramBytes);
  *last = at;
  return true;
}

segcal_flash_t FlashImage::port() {
  return {this, kProgramBytes, kEraseBytes, static_cast<std::uint32_t>(bytes.size() / kEraseBytes),
          read, program,       erase,       [](void*) { return 0; }};
}

}  // namespace host
