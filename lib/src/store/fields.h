// A record as a sequence of fields: listed once, for their number of bytes, for saving, restoring and comparing. The
// fields' bytes are those in memory, which is little-endian on every machine that this is built for.
#pragma once

#include <cstdint>
#include <cstring>
#include <type_traits>

#include "math/types.h"
#include "segcal/segcal.h"

namespace SEGCAL_NS {

static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "the store's fields are written as they stand in memory");

/// Sees a part of the record, [offset, offset + n): a page's worth. Fields are visited from the first at each part,
/// since numbers of entries that stand before say where the others are.
class Fields {
 public:
  enum class Does : std::int32_t { measures, reads, writes, compares };

  Fields() : does_(Does::measures) {}
  /// Copies the part into `out`.
  Fields(std::uint32_t offset, std::uint8_t* out, std::uint32_t n)
      : does_(Does::reads), out_(out), offset_(offset), n_(n) {}
  /// Takes it from `in`, or compares it.
  Fields(Does does, std::uint32_t offset, const std::uint8_t* in, std::uint32_t n)
      : does_(does), in_(in), offset_(offset), n_(n) {}

  std::uint32_t size() const { return at_; }
  bool valid() const { return valid_; }
  /// Comparing: the name of the first field that differs; null if none does.
  const char* difference() const { return difference_; }
  /// What it means: SEGCAL_ERROR_CONFIG or _CAPACITY.
  int error() const { return error_; }
  /// Of the fields that follow.
  void name(const char* name, int error = SEGCAL_ERROR_CONFIG) {
    if (difference_) return;
    name_ = name;
    error_ = error;
  }

  template <class T>
  void array(T* values, std::int32_t n) {
    static_assert(std::is_arithmetic<T>::value && !std::is_same<std::remove_cv_t<T>, bool>::value, "numbers only");
    bytes(values, static_cast<std::uint32_t>(n) * sizeof(T));
  }
  template <class T>
  void number(T* value) {
    array(value, 1);
  }
  /// Told to whoever reads the record; a comparison passes over it.
  void remark(std::uint32_t value) {
    if (does_ == Does::compares) {
      at_ += sizeof value;
    } else {
      number(&value);
    }
  }
  template <class S, int R, int C>
  void matrix(Mat<S, R, C>* m) {
    array(m->data(), R * C);
  }
  void flag(bool* value) { choice(value, 2); }
  /// A number of entries: those that follow are told by it.
  void count(std::int32_t* value, std::int32_t most) {
    number(value);
    if (*value >= 0 && *value <= most) return;
    valid_ = false;
    if (does_ == Does::writes) *value = 0;
  }
  /// Stored as 32 bits. Pages end at multiples of 4 bytes of a record: such fields stand before those of 16 bits.
  template <class E>
  void choice(E* value, std::int32_t choices) {
    std::int32_t i = static_cast<std::int32_t>(*value);
    number(&i);
    if (i < 0 || i >= choices) {
      valid_ = false;
      i = 0;
    }
    if (does_ == Does::writes) *value = static_cast<E>(i);
  }
  /// Structs of numbers without padding.
  template <class T>
  void records(T* values, std::int32_t n, std::size_t size) {
    bytes(static_cast<void*>(values), static_cast<std::uint32_t>(n) * static_cast<std::uint32_t>(size));
  }

 private:
  // One copy of this for some hundred fields: a quarter of the code.
  [[gnu::noinline]] void bytes(void* field, std::uint32_t size) {
    const std::uint32_t begin = at_ > offset_ ? at_ : offset_;
    at_ += size;
    const std::uint32_t end = at_ < offset_ + n_ ? at_ : offset_ + n_;
    if (does_ == Does::measures || begin >= end) return;
    std::uint8_t* here = static_cast<std::uint8_t*>(field) + (begin - (at_ - size));
    const std::uint32_t part = begin - offset_;
    if (does_ == Does::reads) std::memcpy(out_ + part, here, end - begin);
    if (does_ == Does::writes) std::memcpy(here, in_ + part, end - begin);
    if (does_ == Does::compares && !difference_ && std::memcmp(here, in_ + part, end - begin) != 0) difference_ = name_;
  }

  Does does_;
  std::uint8_t* out_ = nullptr;
  const std::uint8_t* in_ = nullptr;
  std::uint32_t offset_ = 0, n_ = 0, at_ = 0;
  bool valid_ = true;
  std::int32_t error_ = SEGCAL_ERROR_CONFIG;
  const char *name_ = "configuration", *difference_ = nullptr;
};

}  // namespace SEGCAL_NS
