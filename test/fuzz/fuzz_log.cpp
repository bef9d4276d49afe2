// A device log. The first byte: bit 0, damaged blocks are left out; bit 1, checksums are made right again, so that what
// the blocks say gets in; bit 2, the log is replayed as a device of profile mcu.
#include <cstring>

#include "device_log/device_log.h"
#include "fuzz_files.h"
#include "log/format.h"
#include "replay/replay.h"

namespace {

using namespace host;

void put32(std::uint8_t* to, std::uint32_t value) {
  for (int i = 0; i < 4; ++i) to[i] = static_cast<std::uint8_t>(value >> 8 * i);
}

std::uint32_t get32(const std::uint8_t* from) {
  return std::uint32_t(from[0]) | std::uint32_t(from[1]) << 8 | std::uint32_t(from[2]) << 16 |
         std::uint32_t(from[3]) << 24;
}

/// Follows the blocks by their sizes, as long as they are inside, and writes what their checksums should be.
void mend_checksums(std::vector<std::uint8_t>* log) {
  using namespace SEGCAL_NS;
  std::memcpy(log->data(), kLogMagic, std::min<std::size_t>(log->size(), kLogMagicBytes));
  for (std::size_t at = kLogMagicBytes; at + kBlockHead + kBlockTail <= log->size();) {
    std::uint8_t* const head = log->data() + at;
    const std::size_t n = get32(head + 8), left = log->size() - at - kBlockHead - kBlockTail;
    if (n > left) return;
    put32(head, kBlockMark);
    put32(head + 12, crc32(head, kBlockHead - 4));
    put32(head + kBlockHead + n, crc32(head + kBlockHead, n));
    at += kBlockHead + n + kBlockTail;
  }
}

void replay_as_device(DeviceLog* log) {
  for (Recording& session : log->sessions) {
    if (session.imu.samples.size() > 4000) return;  // one input, one second
  }
  ReplayOptions options;
  options.profile = "mcu";
  options.core.device_config = log->sessions.front().device->config;
  options.core.calibration = log->calibration;
  options.core.noise = log->noise;
  replay(log->sessions, options);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 1) return 0;
  std::vector<std::uint8_t> bytes(data + 1, data + size);
  if (bytes.empty()) return 0;
  if ((data[0] & 2) != 0) mend_checksums(&bytes);
  reads([&] {
    DeviceLog log = parse_device_log("log", bytes, (data[0] & 1) != 0 ? Damaged::leave_out : Damaged::refuse);
    if ((data[0] & 4) != 0) replay_as_device(&log);
  });
  return 0;
}
