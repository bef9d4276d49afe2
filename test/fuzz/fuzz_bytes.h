// Decisions read from a fuzzer's bytes. At their end all of them are 0.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>

class FuzzBytes {
 public:
  FuzzBytes(const std::uint8_t* data, std::size_t size) : data_(data), size_(size) {}
  bool empty() const { return at_ >= size_; }
  std::uint8_t byte() { return empty() ? std::uint8_t(0) : data_[at_++]; }
  bool flag() { return (byte() & 1) != 0; }
  /// 0..n - 1.
  int below(int n) { return n > 0 ? (n > 256 ? (byte() << 8 | byte()) : byte()) % n : 0; }
  std::int64_t integer() {
    std::uint64_t value = 0;
    for (int i = 0; i < 8; ++i) value = value << 8 | byte();
    return static_cast<std::int64_t>(value);
  }

  /// Overwrites some bytes of a plain struct: with input, or with a value that is an edge of its type.
  template <class T>
  void spoil(T* thing) {
    static const double kEdges[] = {0, -1, 1e300, -1e300, 1e-300, 1e39, 1e18, 4.7e18};
    unsigned char* to = reinterpret_cast<unsigned char*>(thing);
    const std::size_t at = std::size_t(below(int(sizeof(T) < 65536 ? sizeof(T) : 65535)));
    const double edge = kEdges[below(8)];
    const float edge_float = edge > 3e38 ? __builtin_inff() : edge < -3e38 ? __builtin_nanf("") : float(edge);
    switch (below(4)) {
      case 0: to[at] = byte(); break;
      case 1: to[at] = std::uint8_t(to[at] ^ 1u << below(8)); break;
      case 2:
        if (at / 8 * 8 + 8 <= sizeof(T)) std::memcpy(to + at / 8 * 8, &edge, 8);
        break;
      default:
        if (at / 4 * 4 + 4 <= sizeof(T)) std::memcpy(to + at / 4 * 4, &edge_float, 4);
    }
  }

 private:
  const std::uint8_t* data_;
  std::size_t size_, at_ = 0;
};
