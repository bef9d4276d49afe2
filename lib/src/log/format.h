// Bytes of a device log (docs/formats.md): little-endian on every machine, each block with a CRC of its own.
#pragma once

#include <cstddef>
#include <cstdint>

#include "math/bytes.h"
#include "segcal/log.h"

namespace SEGCAL_NS {

constexpr int kLogMagicBytes = 8;
/// Not text, and broken by whatever translates line ends.
constexpr unsigned char kLogMagic[kLogMagicBytes] = {0x89, 'S', 'C', 'L', 'G', '\r', '\n', 0x1A};
constexpr std::uint32_t kBlockMark = 0x4B4C4253u;  ///< "SBLK": where a reader finds on after damage
constexpr std::size_t kBlockHead = 16, kBlockTail = 4;
constexpr std::size_t kStateHead = 8;
/// Of the flash that a device's state is written to.
constexpr std::uint32_t kStateProgramBytes = 256, kStateEraseBytes = 4096;
constexpr std::size_t kImuHead = 12, kImuSample = 32, kTracksHead = 12, kTrackPoint = 13;

enum class LogBlock : std::uint16_t {
  header = 0,
  config = 1,
  imu = 2,
  tracks = 3,
  mark = 4,
  hash = 5,
  end = 6,
  state = 7
};

}  // namespace SEGCAL_NS
