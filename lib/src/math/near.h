// Pointers inside a block of memory that may be moved as bytes: they hold how far away their object is, not where. They
// stay right where both move together.
#pragma once

#include <cstddef>
#include <cstdint>

#include "segcal/config.h"

namespace SEGCAL_NS {

template <class T>
T* pointer_at(std::uintptr_t address) {
  return reinterpret_cast<T*>(address);  // NOLINT(performance-no-int-to-ptr): distances are the point of this file
}

/// Null only until it is assigned to, which nobody asks: one addition to read.
template <class T>
class Near {
 public:
  Near() = default;
  Near(T* object) { point_to(object); }
  Near(const Near& other) { point_to(other); }
  Near& operator=(const Near& other) {
    point_to(other);
    return *this;
  }
  T* get() const { return pointer_at<T>(reinterpret_cast<std::uintptr_t>(this) + distance_); }
  operator T*() const { return get(); }
  T* operator->() const { return get(); }
  /// The object has moved by so many bytes, and this has not.
  void follow(std::ptrdiff_t bytes) { distance_ += static_cast<std::uintptr_t>(bytes); }

 private:
  void point_to(T* object) {
    distance_ = reinterpret_cast<std::uintptr_t>(object) - reinterpret_cast<std::uintptr_t>(this);
  }
  std::uintptr_t distance_ = 0;  ///< bytes from here, modulo the address space
};

template <class T>
class NearOrNull {
 public:
  NearOrNull(T* object = nullptr) { point_to(object); }
  NearOrNull(const NearOrNull& other) { point_to(other); }
  NearOrNull& operator=(const NearOrNull& other) {
    point_to(other);
    return *this;
  }
  operator T*() const {
    return distance_ == 0 ? nullptr : pointer_at<T>(reinterpret_cast<std::uintptr_t>(this) + distance_);
  }
  T* operator->() const { return *this; }
  explicit operator bool() const { return distance_ != 0; }

 private:
  void point_to(T* object) {
    distance_ = object ? reinterpret_cast<std::uintptr_t>(object) - reinterpret_cast<std::uintptr_t>(this) : 0;
  }
  std::uintptr_t distance_;  ///< as Near's; 0: null
};

}  // namespace SEGCAL_NS
