// Ceres beside the core, one thread, double precision, its residuals by automatic derivatives
// (host_tools/src/reference): the information of one segment by ceres::Covariance, against the core's score; the
// calibration of eight segments by Ceres' Levenberg-Marquardt with the Schur complement, against the core's. The
// session is that of device_benchmarks.cpp.
#include <benchmark/benchmark.h>

#include <algorithm>

#include "bench_device.h"
#include "reference/finish.h"
#include "replay/kept_segments.h"

namespace {

/// The eight segments that the core keeps, with its states after the calibration.
const host::KeptSegments& kept() {
  static const host::KeptSegments result = [] {
    const host::SimulationResult session = bench::simulated_session();
    host::ReplayOptions options;
    options.core.calibration = session.nominal;
    options.core.noise = session.recording.imu.noise;
    return host::kept_segments(host::replay({session.recording}, options));
  }();
  return result;
}

/// The largest of them alone.
void ceres_covariance_segment(benchmark::State& state) {
  host::KeptSegments one = kept();
  const auto larger = [](const host::CoreKept& a, const host::CoreKept& b) {
    return a.measured.size() < b.measured.size();
  };
  one.segments = {*std::max_element(kept().segments.begin(), kept().segments.end(), larger)};
  one.segments[0].join = "none";
  const host::reference::Problem problem = host::reference::problem_of(one);
  for (auto _ : state) benchmark::DoNotOptimize(host::reference::theta_covariance(problem, 1).sum());
  state.counters["points"] = static_cast<double>(one.segments[0].measured.size());
}
BENCHMARK(ceres_covariance_segment)->Unit(benchmark::kMillisecond);

/// From the data sheet's theta; states and landmarks start where the core's calibration ended, which is kinder to Ceres
/// than the filter's states that the core starts from.
void ceres_calibrate_8_segments(benchmark::State& state) {
  const host::reference::Problem start = host::reference::problem_of(kept());
  int iterations = 0;
  for (auto _ : state) {
    host::reference::Problem problem = start;
    const host::reference::Fit fit = host::reference::solve(&problem, {});
    if (!fit.converged) state.SkipWithError("did not converge");
    iterations = fit.iterations;
  }
  state.counters["segments"] = static_cast<double>(kept().segments.size());
  state.counters["iterations"] = iterations;
}
BENCHMARK(ceres_calibrate_8_segments)->Unit(benchmark::kMillisecond);

}  // namespace
