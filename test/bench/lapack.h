// LAPACK's QR for comparison, found at run time: neither the build nor the core depends on it.
#pragma once

#include <dlfcn.h>

#include <cstdlib>
#include <vector>

namespace bench {

template <class S>
class Lapack {
 public:
  /// `library`: what dlopen() takes. OpenBLAS works with one thread.
  explicit Lapack(const char* library) {
    setenv("OPENBLAS_NUM_THREADS", "1", 1);
    void* const handle = dlopen(library, RTLD_NOW | RTLD_LOCAL);
    if (!handle) return;
    const char* const name = sizeof(S) == 4 ? "sgeqrf_" : "dgeqrf_";
    geqrf_ = reinterpret_cast<Geqrf>(dlsym(handle, name));
  }
  bool found() const { return geqrf_ != nullptr; }

  /// Triangle of a column-major block of m x n entries, in place; the working space is the best that it asks for.
  void triangle(S* block, int m, int n) {
    int info = 0, ask = -1;
    if (static_cast<int>(tau_.size()) < n) {
      S best = 0;
      tau_.resize(static_cast<std::size_t>(n));
      geqrf_(&m, &n, block, &m, tau_.data(), &best, &ask, &info);
      work_.resize(static_cast<std::size_t>(best));
    }
    int size = static_cast<int>(work_.size());
    geqrf_(&m, &n, block, &m, tau_.data(), work_.data(), &size, &info);
  }

 private:
  using Geqrf = void (*)(const int* m, const int* n, S* a, const int* lda, S* tau, S* work, const int* lwork,
                         int* info);
  Geqrf geqrf_ = nullptr;
  std::vector<S> tau_, work_;
};

constexpr const char* kOpenBlas = "libopenblas.so.0";
/// Netlib's LAPACK, on whatever BLAS the system has chosen.
constexpr const char* kReferenceLapack = "/usr/lib/" SEGCAL_MULTIARCH "/lapack/liblapack.so.3";

}  // namespace bench
