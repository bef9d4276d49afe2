// The three costs that a product plans with: a frame, the score of a segment, a
// calibration. Each benchmark gives the median and the 95 % quantile of its own
// samples and the limit of the median, all in ms; run_benchmarks.cmake compares.
#include <benchmark/benchmark.h>

#include <algorithm>

#include "bench_device.h"

namespace {

using bench::BenchDevice;
using bench::Portion;
using bench::Stopwatch;

const host::SimulationResult& session() {
  static const host::SimulationResult result = bench::simulated_session();
  return result;
}

const std::vector<Portion>& portions() {
  static const std::vector<Portion> all = bench::portions_of(session());
  return all;
}

double quantile(std::vector<double> values, double q) {
  if (values.empty()) return 0;
  const std::size_t i = std::min(values.size() - 1, static_cast<std::size_t>(q * static_cast<double>(values.size())));
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(i), values.end());
  return values[i];
}

void put_times(benchmark::State& state, const std::vector<double>& seconds, double limit_ms) {
  state.counters["median_ms"] = 1e3 * quantile(seconds, 0.5);
  state.counters["p95_ms"] = 1e3 * quantile(seconds, 0.95);
  state.counters["max_ms"] = 1e3 * quantile(seconds, 1);
  state.counters["limit_ms"] = limit_ms;
}

/// An iteration is one frame with the IMU samples before it.
/// Frames that close a segment are measured by the next benchmark.
void vio_frame(benchmark::State& state) {
  BenchDevice device(session());
  std::vector<double> seconds;
  std::size_t next = 0, points = 0;
  for (auto _ : state) {
    if (next == portions().size()) {
      segcal_new_session(device.get());
      next = 0;
    }
    const Portion& portion = portions()[next++];
    const std::uint32_t closed = device.closed();
    const Stopwatch watch;
    const int outcome = device.feed(portion);
    const double spent = watch.seconds();
    state.SetIterationTime(spent);
    if (outcome != SEGCAL_TRACKING || device.closed() != closed) continue;
    seconds.push_back(spent);
    points += portion.points.size();
  }
  put_times(state, seconds, 1);
  state.counters["points"] =
      static_cast<double>(points) / static_cast<double>(std::max<std::size_t>(seconds.size(), 1));
}
BENCHMARK(vio_frame)->UseManualTime()->Unit(benchmark::kMillisecond)->MinTime(2);

/// The number of frames after which the largest segment of the session is complete and still open.
std::size_t frames_of_largest_segment() {
  BenchDevice scout(session());
  std::size_t best = 0;
  std::int32_t most = 0;
  for (std::size_t next = 0; next < portions().size(); ++next) {
    const std::uint32_t closed = scout.closed();
    scout.feed(portions()[next]);
    segcal_segment_t segment{};
    if (scout.closed() == closed || segcal_get_segment(scout.get(), -1, &segment) != SEGCAL_OK) continue;
    if (segment.points <= most) continue;
    most = segment.points;
    best = next;
  }
  return best;
}

/// segcal_flush closes the segment: sorts it, triangulates, eliminates, analyses, computes the metrics and offers it.
void score_segment(benchmark::State& state) {
  BenchDevice device(session());
  const std::size_t frames = frames_of_largest_segment();
  for (std::size_t next = 0; next < frames; ++next) device.feed(portions()[next]);
  const std::vector<char> before = device.photograph();
  std::vector<double> seconds;
  for (auto _ : state) {
    device.restore(before);
    const Stopwatch watch;
    segcal_flush(device.get());
    seconds.push_back(watch.seconds());
    state.SetIterationTime(seconds.back());
  }
  segcal_segment_t segment{};
  segcal_get_segment(device.get(), -1, &segment);
  put_times(state, seconds, 10);
  state.counters["keyframes"] = segment.keyframes;
  state.counters["landmarks"] = segment.landmarks;
  state.counters["points"] = segment.points;
}
BENCHMARK(score_segment)->UseManualTime()->Unit(benchmark::kMillisecond)->MinTime(2);

/// The first calibration of a device: from the data sheet's values, with the filter's states to start from.
void calibrate_8_segments(benchmark::State& state) {
  BenchDevice device(session());
  for (const Portion& portion : portions()) device.feed(portion);
  segcal_flush(device.get());
  const std::vector<char> before = device.photograph();
  std::vector<double> seconds;
  for (auto _ : state) {
    device.restore(before);
    const Stopwatch watch;
    segcal_calibrate(device.get());
    seconds.push_back(watch.seconds());
    state.SetIterationTime(seconds.back());
  }
  segcal_result_t result{};
  segcal_get_result(device.get(), &result);
  if (result.status != SEGCAL_CALIBRATED) state.SkipWithError("the calibration did not succeed");
  put_times(state, seconds, 1000);
  state.counters["segments"] = result.segments;
  state.counters["iterations"] = result.iterations;
  state.counters["points"] = result.image_points;
}
BENCHMARK(calibrate_8_segments)->UseManualTime()->Unit(benchmark::kMillisecond)->MinTime(2);

}  // namespace
