// The QR kernel, in which most of a score is spent, and LAPACK's QR of the same blocks, one thread each. The core folds
// a block at a time into its triangle, as in firmware, where all rows of a segment never stand together; LAPACK gets
// them all at once. Rates count the same useful work for all: that of the triangle of the stacked dense rows, 2 n^2 (m
// - n/3).
//
// Two shapes: dense blocks of a typical landmark's rows, and the rows of a segment
// as they are, each with its own columns: 20 keyframes, 120 landmarks seen for 3
// to 20 keyframes, and one camera. LAPACK's QR takes zeros as any other number.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cstdint>
#include <vector>

#include "lapack.h"
#include "math/qr.h"

namespace {

using SEGCAL_NS::ColumnGap;
using SEGCAL_NS::packed_size;
using SEGCAL_NS::PackedTriangle;

/// Rows that are folded together.
struct Block {
  int first_row, rows;
  int first, last_pose;  ///< columns of the poses: [first, last_pose)
};

/// Row-major rows with the columns [poses | camera and right-hand side].
template <class S>
struct Stack {
  int columns = 0, poses = 0, rows = 0;
  std::vector<Block> blocks;
  std::vector<S> entry;

  double flop() const { return 2.0 * columns * columns * (rows - columns / 3.0); }
};

/// Numbers between -1 and 1 where a block has columns.
template <class S>
void fill(Stack<S>* stack) {
  std::uint32_t number = 1;
  stack->entry.assign(static_cast<std::size_t>(stack->rows * stack->columns), S(0));
  for (const Block& block : stack->blocks) {
    for (int i = block.first_row; i < block.first_row + block.rows; ++i) {
      for (int c = block.first; c < stack->columns; ++c) {
        if (c >= block.last_pose && c < stack->poses) continue;
        number = 1664525u * number + 1013904223u;
        stack->entry[static_cast<std::size_t>(i * stack->columns + c)] =
            static_cast<S>(number >> 8) / S(8388608) - S(1);
      }
    }
  }
}

/// 9 image points of each landmark, after its own three columns have gone: 16 rows.
template <class S>
Stack<S> dense_stack() {
  Stack<S> stack;
  stack.columns = 6 * 13 + 12;
  stack.poses = 6 * 13;
  for (int i = 0; i < 40; ++i) stack.blocks.push_back({16 * i, 16, 0, stack.poses});
  stack.rows = 16 * 40;
  fill(&stack);
  return stack;
}

/// Landmarks that end early come first, as in the core.
template <class S>
Stack<S> segment_stack() {
  constexpr int kKeyframes = 20, kLandmarks = 120;
  Stack<S> stack;
  stack.columns = 6 * kKeyframes + 12;
  stack.poses = 6 * kKeyframes;
  std::vector<Block> blocks;
  std::uint32_t number = 7;
  const auto below = [&number](int n) {
    number = 1664525u * number + 1013904223u;
    return static_cast<int>((number >> 16) % static_cast<std::uint32_t>(n));
  };
  for (int i = 0; i < kLandmarks; ++i) {
    const int length = 3 + below(kKeyframes - 2), first = below(kKeyframes - length + 1);
    blocks.push_back({0, 2 * length - 2, 6 * first, 6 * (first + length)});
  }
  std::stable_sort(blocks.begin(), blocks.end(),
                   [](const Block& a, const Block& b) { return a.last_pose < b.last_pose; });
  for (Block& block : blocks) {
    block.first_row = stack.rows;
    stack.rows += block.rows;
  }
  stack.blocks = blocks;
  fill(&stack);
  return stack;
}

template <class S>
void report(benchmark::State& state, const Stack<S>& stack) {
  state.counters["MFLOP_per_s"] =
      benchmark::Counter(1e-6 * stack.flop(), benchmark::Counter::kIsIterationInvariantRate);
}

/// Each iteration starts from an empty triangle and pays for the copy of the rows, which are destroyed.
template <class S>
void run_core(benchmark::State& state, const Stack<S>& stack) {
  const int n = stack.columns;
  std::vector<S> triangle(static_cast<std::size_t>(packed_size(n))), block, work(static_cast<std::size_t>(n));
  PackedTriangle<S> R(triangle.data(), n);
  for (auto _ : state) {
    R.clear();
    int seen = 0;  // columns of poses that rows have touched so far
    for (const Block& b : stack.blocks) {
      const auto from = stack.entry.begin() + b.first_row * n;
      block.assign(from, from + b.rows * n);
      seen = std::max(seen, b.last_pose);
      SEGCAL_NS::fold_rows(R, block.data(), b.rows, n, b.first, n, ColumnGap{seen, stack.poses});
    }
    benchmark::DoNotOptimize(triangle[0]);
  }
  report(state, stack);
}

template <class S>
void run_lapack(benchmark::State& state, const Stack<S>& stack, const char* library) {
  bench::Lapack<S> lapack(library);
  if (!lapack.found()) return state.SkipWithError("not installed");
  std::vector<S> columns(stack.entry.size()), block;
  for (int i = 0; i < stack.rows; ++i) {
    for (int c = 0; c < stack.columns; ++c) {
      columns[static_cast<std::size_t>(c * stack.rows + i)] =
          stack.entry[static_cast<std::size_t>(i * stack.columns + c)];
    }
  }
  for (auto _ : state) {
    block = columns;
    lapack.triangle(block.data(), stack.rows, stack.columns);
    benchmark::DoNotOptimize(block[0]);
  }
  report(state, stack);
}

void qr_dense(benchmark::State& s) { run_core(s, dense_stack<float>()); }
void qr_dense_sgeqrf(benchmark::State& s) { run_lapack(s, dense_stack<float>(), bench::kOpenBlas); }
void qr_dense_dgeqrf(benchmark::State& s) { run_lapack(s, dense_stack<double>(), bench::kOpenBlas); }
void qr_dense_sgeqrf_reference(benchmark::State& s) { run_lapack(s, dense_stack<float>(), bench::kReferenceLapack); }
void qr_segment(benchmark::State& s) { run_core(s, segment_stack<float>()); }
void qr_segment_sgeqrf(benchmark::State& s) { run_lapack(s, segment_stack<float>(), bench::kOpenBlas); }
void qr_segment_dgeqrf(benchmark::State& s) { run_lapack(s, segment_stack<double>(), bench::kOpenBlas); }
void qr_segment_sgeqrf_reference(benchmark::State& s) {
  run_lapack(s, segment_stack<float>(), bench::kReferenceLapack);
}

BENCHMARK(qr_dense)->Unit(benchmark::kMillisecond);
BENCHMARK(qr_dense_sgeqrf)->Unit(benchmark::kMillisecond);
BENCHMARK(qr_dense_dgeqrf)->Unit(benchmark::kMillisecond);
BENCHMARK(qr_dense_sgeqrf_reference)->Unit(benchmark::kMillisecond);
BENCHMARK(qr_segment)->Unit(benchmark::kMillisecond);
BENCHMARK(qr_segment_sgeqrf)->Unit(benchmark::kMillisecond);
BENCHMARK(qr_segment_dgeqrf)->Unit(benchmark::kMillisecond);
BENCHMARK(qr_segment_sgeqrf_reference)->Unit(benchmark::kMillisecond);

}  // namespace
