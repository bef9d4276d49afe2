// Memory for one of several objects at a time: a union that, in builds with SEGCAL_ASSERT, knows which one it holds.
//
// Large parts of the core are needed one after the other, never together. Where they share memory, this says by name
// what begins and what is asked for; builds with SEGCAL_ASSERT stop where that is not what is there. Others keep no
// tag: a profile of 256 KiB has no byte for what nobody reads.
#pragma once

#include <cstddef>
#include <cstdint>
#include <new>
#include <type_traits>

#include "math/types.h"

namespace SEGCAL_NS {

#if defined(SEGCAL_ASSERT) && SEGCAL_ASSERT
constexpr bool kKnowsWhatItHolds = true;
#else
constexpr bool kKnowsWhatItHolds = false;
#endif

/// A number by which something knows what it holds, or nothing: a base class, so that nothing takes no memory.
template <bool knows>
class Held {
 public:
  void set(std::size_t number) { number_ = number; }
  bool is(std::size_t number) const { return number_ == number; }

 private:
  std::size_t number_ = 0;  ///< 0: nothing yet
};
template <>
class Held<false> {
 public:
  void set(std::size_t) {}
  bool is(std::size_t) const { return true; }
};

template <class... T>
class OneOf : Held<kKnowsWhatItHolds> {
  static_assert((std::is_trivially_destructible_v<T> && ...), "what is there ends without a destructor");

 public:
  OneOf() = default;
  OneOf(const OneOf&) = delete;  // what it holds may point into itself (near.h)
  OneOf& operator=(const OneOf&) = delete;
  /// Begins an X, default-initialised; what was there has ended.
  template <class X>
  X& begin() {
    this->set(number<X>());
    return *new (bytes_) X;
  }
  /// The X that was begun last.
  template <class X>
  X& get() {
    eigen_assert(this->is(number<X>()));
    return *std::launder(static_cast<X*>(static_cast<void*>(bytes_)));
  }
  template <class X>
  const X& get() const {
    eigen_assert(this->is(number<X>()));
    return *std::launder(static_cast<const X*>(static_cast<const void*>(bytes_)));
  }

 private:
  /// 1, 2, ... in the order of the list.
  template <class X>
  static constexpr std::size_t number() {
    static_assert((std::is_same_v<X, T> || ...), "not one of the list");
    std::size_t n = 0, found = 0;
    ((++n, found = std::is_same_v<X, T> ? n : found), ...);
    return found;
  }
  static constexpr std::size_t largest() {
    std::size_t most = 0;
    ((most = sizeof(T) > most ? sizeof(T) : most), ...);
    return most;
  }

  alignas(T...) unsigned char bytes_[largest()];
};

}  // namespace SEGCAL_NS
