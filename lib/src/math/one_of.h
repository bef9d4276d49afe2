// Memory for one of several objects at a time: a union that knows which one it holds.
//
// Large parts of the core are needed one after the other, never together. Where they share memory, this says by name
// what begins and what is asked for; builds with SEGCAL_ASSERT stop where that is not what is there.
#pragma once

#include <cstddef>
#include <cstdint>
#include <new>
#include <type_traits>

#include "math/types.h"

namespace SEGCAL_NS {

template <class... T>
class OneOf {
  static_assert((std::is_trivially_destructible_v<T> && ...), "what is there ends without a destructor");

 public:
  OneOf() = default;
  OneOf(const OneOf&) = delete;  // what it holds may point into itself (near.h)
  OneOf& operator=(const OneOf&) = delete;
  /// Begins an X, default-initialised; what was there has ended.
  template <class X>
  X& begin() {
    holds_ = number<X>();
    return *new (bytes_) X;
  }
  /// The X that was begun last.
  template <class X>
  X& get() {
    eigen_assert(holds<X>());
    return *std::launder(static_cast<X*>(static_cast<void*>(bytes_)));
  }
  template <class X>
  const X& get() const {
    eigen_assert(holds<X>());
    return *std::launder(static_cast<const X*>(static_cast<const void*>(bytes_)));
  }
  template <class X>
  bool holds() const {
    return holds_ == number<X>();
  }

 private:
  /// 1, 2, ... in the order of the list.
  template <class X>
  static constexpr std::int32_t number() {
    static_assert((std::is_same_v<X, T> || ...), "not one of the list");
    std::int32_t n = 0, found = 0;
    ((++n, found = std::is_same_v<X, T> ? n : found), ...);
    return found;
  }
  static constexpr std::size_t largest() {
    std::size_t most = 0;
    ((most = sizeof(T) > most ? sizeof(T) : most), ...);
    return most;
  }

  alignas(T...) unsigned char bytes_[largest()];
  std::int32_t holds_ = 0;  ///< 0: nothing yet
};

}  // namespace SEGCAL_NS
