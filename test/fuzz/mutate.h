// Inputs for a fuzz target without a fuzzer: a file of a corpus, changed in a few places. The seed decides everything.
#pragma once

#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

class Mutator {
 public:
  using Bytes = std::vector<std::uint8_t>;

  explicit Mutator(std::uint64_t seed) : state_(seed) {}

  Bytes random_bytes() {
    Bytes bytes(16 + next() % 112);
    for (std::uint8_t& b : bytes) b = static_cast<std::uint8_t>(next());
    return bytes;
  }

  /// Most inputs have one to four changes: one with many does not come past a reader's first check.
  Bytes changed(const std::vector<Bytes>& corpus) {
    Bytes bytes = corpus[next() % corpus.size()];
    for (std::uint64_t n = 1 + next() % 4; n > 0; --n) change(&bytes, corpus[next() % corpus.size()]);
    return bytes;
  }

 private:
  std::uint64_t next() {  // splitmix64 (Steele, Lea and Flood 2014)
    std::uint64_t z = (state_ += 0x9E3779B97F4A7C15ull);
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ull;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBull;
    return z ^ (z >> 31);
  }

  void change(Bytes* bytes, const Bytes& other) {
    const std::size_t at = bytes->empty() ? 0 : next() % bytes->size();
    switch (next() % 10) {
      case 0:
        if (!bytes->empty()) (*bytes)[at] = static_cast<std::uint8_t>(next());
        break;
      case 1:
        if (!bytes->empty()) (*bytes)[at] ^= static_cast<std::uint8_t>(1u << next() % 8);
        break;
      case 2: bytes->resize(at); break;  // cut off
      case 3:
        bytes->erase(bytes->begin() + long(at),
                     bytes->begin() + long(at + next() % (1 + std::min<std::size_t>(bytes->size() - at, 64))));
        break;
      case 4: insert(bytes, at, piece(*bytes)); break;  // a piece twice
      case 5: insert(bytes, at, piece(other)); break;
      case 6: replace_number(bytes, at); break;
      case 7: replace_number(bytes, at); break;
      case 8: insert(bytes, at, word()); break;
      default: overwrite(bytes, at);
    }
  }

  Bytes piece(const Bytes& of) {
    if (of.empty()) return {};
    const std::size_t from = next() % of.size();
    return Bytes(of.begin() + long(from), of.begin() + long(std::min(of.size(), from + next() % 64)));
  }

  static void insert(Bytes* bytes, std::size_t at, const Bytes& what) {
    bytes->insert(bytes->begin() + long(at), what.begin(), what.end());
  }

  /// What parsers stumble over.
  Bytes word() {
    static const char* const kWords[] = {"nan",
                                         "inf",
                                         "-inf",
                                         "1e300",
                                         "-1e300",
                                         "1e-300",
                                         "1e39",
                                         "0",
                                         "-1",
                                         "9223372036854775807",
                                         "-9223372036854775808",
                                         "18446744073709551616",
                                         "4294967295",
                                         "2147483648",
                                         "\"",
                                         "[",
                                         "]",
                                         "{",
                                         "}",
                                         ":",
                                         ",",
                                         "\n",
                                         "- ",
                                         "#",
                                         "&a ",
                                         "*a",
                                         "null",
                                         "true",
                                         "[]",
                                         "{}",
                                         "\xff",
                                         "\xc3\xa9",
                                         "~",
                                         "!!binary ",
                                         "\t",
                                         "'"};
    const char* const text = kWords[next() % (sizeof kWords / sizeof *kWords)];
    return Bytes(text, text + std::strlen(text));
  }

  /// The number in a text that begins at or after `at`.
  void replace_number(Bytes* bytes, std::size_t at) {
    const auto digit = [&](std::size_t i) { return i < bytes->size() && ((*bytes)[i] >= '0' && (*bytes)[i] <= '9'); };
    const auto part = [&](std::size_t i) {
      return digit(i) || (i < bytes->size() && std::strchr("+-.e", (*bytes)[i]) && (*bytes)[i] != 0);
    };
    while (at < bytes->size() && !digit(at)) ++at;
    while (at > 0 && part(at - 1)) --at;
    std::size_t end = at;
    while (part(end)) ++end;
    bytes->erase(bytes->begin() + long(at), bytes->begin() + long(end));
    insert(bytes, at, word());
  }

  /// Binary numbers at the edges of their types.
  void overwrite(Bytes* bytes, std::size_t at) {
    static const double kEdges[] = {0, -1, 1e300, -1e300, 1e-300, 1e39, 1e18, 4.7e18};
    const double edge = kEdges[next() % 8];
    const float edge_float = edge > 3e38    ? __builtin_inff()
                             : edge < -3e38 ? __builtin_nanf("")
                                            : static_cast<float>(edge);
    const std::uint64_t whole = next() % 2 ? ~std::uint64_t{0} >> next() % 64 : next() % 300;
    const std::size_t size = next() % 2 ? 4 : 8;
    if (at + size > bytes->size()) return;
    if (next() % 2) return void(std::memcpy(bytes->data() + at, &whole, size));
    size == 8 ? std::memcpy(bytes->data() + at, &edge, 8) : std::memcpy(bytes->data() + at, &edge_float, 4);
  }

  std::uint64_t state_;
};
