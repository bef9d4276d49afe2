// Numbers as bytes, little-endian on every machine, and the checksum over them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>

#include "segcal/config.h"

namespace SEGCAL_NS {

/// CRC-32 of IEEE 802.3, the one of zip and Ethernet, piece by piece. Four bits at a time: a table of 64 bytes.
class Crc32 {
 public:
  void add(const std::uint8_t* bytes, std::size_t n) {
    static const std::uint32_t kTable[16] = {
        0x00000000u, 0x1DB71064u, 0x3B6E20C8u, 0x26D930ACu, 0x76DC4190u, 0x6B6B51F4u, 0x4DB26158u, 0x5005713Cu,
        0xEDB88320u, 0xF00F9344u, 0xD6D6A3E8u, 0xCB61B38Cu, 0x9B64C2B0u, 0x86D3D2D4u, 0xA00AE278u, 0xBDBDF21Cu};
    for (std::size_t i = 0; i < n; ++i) {
      crc_ ^= bytes[i];
      crc_ = crc_ >> 4 ^ kTable[crc_ & 15u];
      crc_ = crc_ >> 4 ^ kTable[crc_ & 15u];
    }
  }
  std::uint32_t value() const { return ~crc_; }

 private:
  std::uint32_t crc_ = 0xFFFFFFFFu;
};

inline std::uint32_t crc32(const std::uint8_t* bytes, std::size_t n) {
  Crc32 crc;
  crc.add(bytes, n);
  return crc.value();
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
