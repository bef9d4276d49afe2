// FNV-1a with 64 bits over 32-bit words: the same on every machine, whatever its order of bytes.
#pragma once

#include <cstdint>
#include <cstring>

#include "segcal/config.h"

namespace SEGCAL_NS {

class Hash {
 public:
  Hash() = default;
  /// Goes on from a value().
  explicit Hash(std::uint64_t value) : value_(value) {}
  std::uint64_t value() const { return value_; }

  void add(std::uint32_t word) {
    value_ ^= word;
    value_ *= 0x100000001B3ull;
  }
  void add(std::int32_t word) { add(static_cast<std::uint32_t>(word)); }
  void add(std::uint64_t word) {
    add(static_cast<std::uint32_t>(word));
    add(static_cast<std::uint32_t>(word >> 32));
  }
  void add(std::int64_t word) { add(static_cast<std::uint64_t>(word)); }
  /// The bits of a number. A not-a-number is one value: its sign and payload differ between processors.
  void add(float number) {
    std::uint32_t word;
    std::memcpy(&word, &number, sizeof word);
    add(number != number ? 0x7FC00000u : word);
  }
  void add(double number) {
    std::uint64_t word;
    std::memcpy(&word, &number, sizeof word);
    add(number != number ? std::uint64_t(0x7FF8000000000000u) : word);
  }
  template <class T>
  void add(const T* numbers, int n) {
    for (int i = 0; i < n; ++i) add(numbers[i]);
  }

 private:
  std::uint64_t value_ = 0xCBF29CE484222325ull;
};

}  // namespace SEGCAL_NS
