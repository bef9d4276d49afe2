// Feeds a device log to the core, compiled right here with the options of one variant, and prints the result hash.
// Neither the input nor the output passes through code that another variant compiles differently.
//
// usage: session_hash LOG [SLICES]      SLICES: of background work after each sample; 0: all is done where it must be
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <vector>

#include "api/handle.h"
#include "log/config_fields.h"

namespace {

using namespace SEGCAL_NS;
using Bytes = std::vector<std::uint8_t>;

[[noreturn]] void stop(const char* what) {
  std::fprintf(stderr, "session_hash: %s\n", what);
  std::exit(2);
}

int slices_per_sample = 0;
std::uint32_t longest_wait = 0, waited = 0;  // in samples

/// What the background does between two samples.
void work(Device<Real>* device) {
  waited = device->background(slices_per_sample) > 0 ? waited + 1 : 0;
  if (waited > longest_wait) longest_wait = waited;
}

void feed_samples(ByteReader in, Device<Real>* device) {
  const std::int64_t t0 = in.integer<std::int64_t>();
  for (std::uint32_t n = in.integer<std::uint32_t>(); n > 0; --n) {
    const std::int64_t t = t0 + in.integer<std::int32_t>();
    InertialReading<Real> reading;
    for (int i = 0; i < 3; ++i) reading.gyro(i) = in.number32();
    for (int i = 0; i < 3; ++i) reading.accel(i) = in.number32();
    const float celsius = in.number32();
    device->push_imu(t, reading, Real(celsius));
    work(device);
  }
}

void feed_frame(ByteReader in, Device<Real>* device) {
  static TrackPoint<Real> points[kMaxFramePoints];
  const std::int64_t t = in.integer<std::int64_t>();
  const std::int32_t n = in.integer<std::int32_t>();
  if (n > kMaxFramePoints) stop("too many points");
  for (std::int32_t i = 0; i < n; ++i) {
    points[i].id = in.integer<std::uint32_t>();
    points[i].camera = in.integer<std::uint8_t>();
    points[i].uv.x() = in.number32();
    points[i].uv.y() = in.number32();
  }
  device->push_tracks(t, n, [](int i) { return points[i]; });
}

ColdParts<Real> cold;

void take_block(LogBlock type, const std::uint8_t* payload, std::size_t n, Device<Real>* device) {
  switch (type) {
    case LogBlock::config: {
      segcal_config_t config;
      DeviceOptions<Real> options;
      if (!read_config(payload, n, &config)) stop("a configuration of another layout");
      if (!options_from_config(config, &options)) stop("a configuration that is refused");
      device->create(options, &cold);
      device->work_when_due(true);
      return;
    }
    case LogBlock::imu: return feed_samples(ByteReader(payload, n), device);
    case LogBlock::tracks: return feed_frame(ByteReader(payload, n), device);
    case LogBlock::mark:
      if (*payload == SEGCAL_LOG_NEW_SESSION) device->new_session();
      if (*payload == SEGCAL_LOG_REQUEST_CALIBRATION) device->request_calibration();
      if (*payload == SEGCAL_LOG_FLUSH) device->flush();
      if (*payload == SEGCAL_LOG_CALIBRATE) device->calibrate();
      return;
    default: return;
  }
}

}  // namespace

int main(int argc, char** argv) {
  static Device<Real> device;
  slices_per_sample = argc > 2 ? std::atoi(argv[2]) : 0;
  std::ifstream file(argc > 1 ? argv[1] : "", std::ios::binary);
  const Bytes bytes((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  if (bytes.size() < 100) stop("no log");
  for (std::size_t at = kLogMagicBytes; at + kBlockHead <= bytes.size();) {
    ByteReader head(bytes.data() + at, kBlockHead);
    head.integer<std::uint32_t>();
    const LogBlock type = static_cast<LogBlock>(head.integer<std::uint16_t>());
    head.integer<std::uint16_t>();
    const std::size_t n = head.integer<std::uint32_t>();
    take_block(type, bytes.data() + at + kBlockHead, n, &device);
    at += kBlockHead + n + kBlockTail;
  }
  if (!device.has_report() || device.database().size() < 2) stop("the session did not come to a calibration");
  if (device.faults().segments_missed == 0) stop("no segment ended while a calibration was under way");
  std::fprintf(stderr,
               "%d slices per sample: %u calibrations, %u segments missed, late %u times, at most %u samples long\n",
               slices_per_sample, device.faults().calibrations, device.faults().segments_missed,
               device.faults().slices_late, longest_wait);
  std::printf("result_hash %016llx\n", static_cast<unsigned long long>(device.result_hash()));
  return 0;
}
