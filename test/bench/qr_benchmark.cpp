// The QR kernel, in which most of a score is spent: without a limit, to compare machines and versions.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cstdint>
#include <iterator>

#include "math/qr.h"

namespace {

/// Rows of a typical landmark (9 image points) folded into a triangle of typical width: 13 poses and one camera.
/// Each iteration starts from an empty triangle, so that its numbers do not grow.
void qr_kernel(benchmark::State& state) {
  using SEGCAL_NS::PackedTriangle;
  constexpr int kRows = 16, kColumns = 6 * 13 + 12, kBlocks = 40;
  static float block[kRows * kColumns], start[kRows * kColumns], triangle[SEGCAL_NS::packed_size(kColumns)], work[kColumns];
  std::uint32_t number = 1;
  for (float& x : start) {
    number = 1664525u * number + 1013904223u;
    x = static_cast<float>(number >> 8) / 8388608.0f - 1.0f;
  }
  PackedTriangle<float> R(triangle, kColumns);
  for (auto _ : state) {
    R.clear();
    for (int i = 0; i < kBlocks; ++i) {
      std::copy(std::begin(start), std::end(start), std::begin(block));
      SEGCAL_NS::fold_rows(R, block, kRows, kColumns, 0, kColumns, work);
    }
    benchmark::DoNotOptimize(triangle[0]);
  }
  // Column j: two passes of a multiplication and an addition over m + 1 rows and n - j - 1 columns.
  const double per_block = 4.0 * (kRows + 1) * kColumns * (kColumns - 1) / 2;
  state.counters["rows_per_s"] = benchmark::Counter(kRows * kBlocks, benchmark::Counter::kIsIterationInvariantRate);
  state.counters["MFLOP_per_s"] = benchmark::Counter(1e-6 * per_block * kBlocks, benchmark::Counter::kIsIterationInvariantRate);
}
BENCHMARK(qr_kernel)->Unit(benchmark::kMillisecond);

}  // namespace
