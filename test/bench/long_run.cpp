// Ten hours of stream through one device, fed and scored but never calibrated: is anything
// different at the end? A simulated session of some minutes runs in a loop with stamps that go
// on; between two turns is a gap of a second, over which the device starts its filter again, and
// keeps its database. `segcal_long_run [hours]`: takes minutes; not part of the target `bench`.
//
// Limits (exit code 1): the median CPU time of a segment in any hour is within 3 % of the first hour's. CPU time, not
// wall clock: other programs take turns on this machine. With fewer hours the ten parts that are compared are shorter.
#include <time.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "bench_device.h"

namespace {

constexpr double kSessionSeconds = 300;  // what is simulated
constexpr int kParts = 10;               // of the run: hours, if it is ten

double cpu_seconds() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

double median(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

void shift(std::vector<bench::Portion>* portions, std::int64_t by_ns, std::uint32_t by_id) {
  for (bench::Portion& portion : *portions) {
    portion.t_ns += by_ns;
    for (segcal_imu_t& sample : portion.imu) sample.t_ns += by_ns;
    for (segcal_point_t& point : portion.points) point.track_id += by_id;
  }
}

struct Run {
  std::vector<double> segment_s[kParts];  ///< CPU time of all frames of a segment, its score included
  std::size_t state_bytes[kParts] = {};
};

/// Feeds one turn and notes what each segment took.
void feed_session(bench::BenchDevice& device, const std::vector<bench::Portion>& portions,
                  std::vector<double>* segment_s) {
  std::uint32_t closed = device.closed();
  double start = cpu_seconds();
  bool whole = false;  // the first one of a turn waits for the filter's start
  for (const bench::Portion& portion : portions) {
    device.feed(portion);
    if (device.closed() == closed) continue;
    closed = device.closed();
    const double now = cpu_seconds();
    if (whole) segment_s->push_back(now - start);
    whole = true;
    start = now;
  }
}

Run run(const host::SimulationResult& session, double hours) {
  bench::BenchDevice device(session);
  std::vector<bench::Portion> portions = bench::portions_of(session);
  const std::int64_t length_ns = static_cast<std::int64_t>((kSessionSeconds + 1) * 1e9);
  const int turns = static_cast<int>(std::ceil(hours * 3600 / kSessionSeconds));
  Run out;
  for (int turn = 0; turn < turns; ++turn) {
    const int part = turn * kParts / turns;
    feed_session(device, portions, &out.segment_s[part]);
    segcal_memory(&out.state_bytes[part], nullptr, nullptr);
    shift(&portions, length_ns, 10000000);
    if ((turn + 1) % 12 == 0) std::fprintf(stderr, "%d of %d sessions\n", turn + 1, turns);
  }
  return out;
}

}  // namespace

int main(int argc, char** argv) {
  const double hours = argc > 1 ? std::atof(argv[1]) : 10;
  host::SimulationOptions options;
  options.scenario = "rich";
  options.seconds = kSessionSeconds;
  options.seed = 1;
  const host::SimulationResult session = host::simulate(options);
  const Run r = run(session, hours);
  const double first = median(r.segment_s[0]);
  bool good = true;
  std::printf("%8s %10s %14s %12s %12s\n", "from h", "segments", "median ms", "of first", "state_bytes");
  for (int part = 0; part < kParts; ++part) {
    if (r.segment_s[part].empty()) continue;
    const double ratio = median(r.segment_s[part]) / first;
    std::printf("%8.2f %10zu %14.3f %12.4f %12zu\n", part * hours / kParts, r.segment_s[part].size(),
                1e3 * ratio * first, ratio, r.state_bytes[part]);
    good = good && std::abs(ratio - 1) <= 0.03 && r.state_bytes[part] == r.state_bytes[0];
  }
  std::puts(good ? "within 3 % of the first part, state_bytes the same" : "beyond 3 % of the first part");
  return good ? 0 : 1;
}
