// What the rule "the same bits from every build" costs: the CPU time of a frame, a score and a calibration. Built
// twice, with the rule and with all that a compiler may do without it (CMakeLists.txt); run_bit_rule.cmake compares.
#include <algorithm>
#include <cstdio>
#include <ctime>

#include "bench_device.h"

namespace {

/// Of this thread alone: other work on the machine does not count.
class CpuWatch {
 public:
  double ms() const { return now() - start_; }

 private:
  static double now() {
    timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return 1e3 * static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_nsec);
  }
  double start_ = now();
};

/// The quickest of n runs from the same memory: what disturbs only ever adds time.
template <class Work>
double quickest(int n, bench::BenchDevice* device, const std::vector<char>& before, Work work) {
  double best = 1e9;
  for (int i = 0; i < n; ++i) {
    device->restore(before);
    const CpuWatch watch;
    work();
    best = std::min(best, watch.ms());
  }
  return best;
}

}  // namespace

int main() {
  const host::SimulationResult session = bench::simulated_session();
  const std::vector<bench::Portion> portions = bench::portions_of(session);
  bench::BenchDevice device(session);
  std::vector<double> frames;
  std::vector<char> open_segment;
  for (std::size_t i = 0; i < portions.size(); ++i) {
    const CpuWatch watch;
    device.feed(portions[i]);
    frames.push_back(watch.ms());
    if (i == portions.size() * 4 / 5) open_segment = device.photograph();
  }
  segcal_flush(device.get());
  const std::vector<char> full_database = device.photograph();
  // A lower quartile: frames that close a segment are few.
  std::nth_element(frames.begin(), frames.begin() + static_cast<std::ptrdiff_t>(frames.size() / 4), frames.end());
  std::printf("frame %.4f\n", frames[frames.size() / 4]);
  std::printf("score %.4f\n", quickest(50, &device, open_segment, [&device] { segcal_flush(device.get()); }));
  std::printf("calibrate %.3f\n", quickest(10, &device, full_database, [&device] { segcal_calibrate(device.get()); }));
}
