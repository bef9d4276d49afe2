// Bytes of a device log (docs/formats.md): little-endian on every machine, each block with a CRC of its own.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>

#include "segcal/log.h"

namespace SEGCAL_NS {

constexpr int kLogMagicBytes = 8;
/// Not text, and broken by whatever translates line ends.
constexpr unsigned char kLogMagic[kLogMagicBytes] = {0x89, 'S', 'C', 'L', 'G', '\r', '\n', 0x1A};
constexpr std::uint32_t kBlockMark = 0x4B4C4253u;  ///< "SBLK": where a reader finds on after damage
constexpr std::size_t kBlockHead = 16, kBlockTail = 4;
constexpr std::size_t kImuHead = 12, kImuSample = 32, kTracksHead = 12, kTrackPoint = 13;

enum class LogBlock : std::uint16_t { header = 0, config = 1, imu = 2, tracks = 3, mark = 4, hash = 5, end = 6 };

/// CRC-32 of IEEE 802.3, the one of zip and Ethernet. Four bits at a time: a table of 64 bytes.
inline std::uint32_t crc32(const std::uint8_t* bytes, std::size_t n) {
  static const std::uint32_t kTable[16] = {0x00000000u, 0x1DB71064u, 0x3B6E20C8u, 0x26D930ACu, 0x76DC4190u, 0x6B6B51F4u,
                                           0x4DB26158u, 0x5005713Cu, 0xEDB88320u, 0xF00F9344u, 0xD6D6A3E8u, 0xCB61B38Cu,
                                           0x9B64C2B0u, 0x86D3D2D4u, 0xA00AE278u, 0xBDBDF21Cu};
  std::uint32_t crc = 0xFFFFFFFFu;
  for (std::size_t i = 0; i < n; ++i) {
    crc ^= bytes[i];
    crc = crc >> 4 ^ kTable[crc & 15u];
    crc = crc >> 4 ^ kTable[crc & 15u];
  }
  return ~crc;
}

/// Appends numbers to memory of the caller's; what has no room is left out and `fits` becomes false.
class ByteWriter {
 public:
  ByteWriter(std::uint8_t* bytes, std::size_t capacity) : bytes_(bytes), capacity_(capacity) {}
  std::size_t size() const { return size_; }
  bool fits() const { return fits_; }

  template <class T>
  void integer(T value) {
    const std::uint64_t bits = static_cast<std::uint64_t>(value);
    for (std::size_t i = 0; i < sizeof(T); ++i) byte(static_cast<std::uint8_t>(bits >> (8 * i)));
  }
  void number(float value) {
    std::uint32_t bits;
    std::memcpy(&bits, &value, sizeof bits);
    integer(bits);
  }
  void number(double value) {
    std::uint64_t bits;
    std::memcpy(&bits, &value, sizeof bits);
    integer(bits);
  }

 private:
  void byte(std::uint8_t b) {
    fits_ = fits_ && size_ < capacity_;
    if (fits_) bytes_[size_++] = b;
  }
  std::uint8_t* bytes_;
  std::size_t capacity_, size_ = 0;
  bool fits_ = true;
};

/// Takes numbers from memory; behind the end they are zero and `complete` is false.
class ByteReader {
 public:
  ByteReader(const std::uint8_t* bytes, std::size_t size) : bytes_(bytes), left_(size) {}
  std::size_t left() const { return left_; }
  bool complete() const { return complete_; }

  template <class T>
  T integer() {
    std::uint64_t bits = 0;
    for (std::size_t i = 0; i < sizeof(T); ++i) bits |= static_cast<std::uint64_t>(byte()) << (8 * i);
    return static_cast<T>(bits);
  }
  float number32() {
    const std::uint32_t bits = integer<std::uint32_t>();
    float value;
    std::memcpy(&value, &bits, sizeof value);
    return value;
  }
  double number64() {
    const std::uint64_t bits = integer<std::uint64_t>();
    double value;
    std::memcpy(&value, &bits, sizeof value);
    return value;
  }

 private:
  std::uint8_t byte() {
    complete_ = complete_ && left_ > 0;
    if (!complete_) return 0;
    --left_;
    return *bytes_++;
  }
  const std::uint8_t* bytes_;
  std::size_t left_;
  bool complete_ = true;
};

}  // namespace SEGCAL_NS
