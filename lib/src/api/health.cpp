// What keeps the odometry from running: the first cause that the counters show.
#include "api/handle.h"

namespace SEGCAL_NS {
namespace {

/// Starts in motion without success after which the motion is not to blame: hands, feet and vehicles start within the first ones.
constexpr std::int32_t kStartsTried = 5;
/// s that the filter should run without being lost: as long as two segments.
constexpr double kRunSeconds = 10;

int cause_before_running(const FaultCounts& f, const VioStatistics& v) {
  if (2 * f.frames_few_tracks > static_cast<std::uint32_t>(v.frames)) return SEGCAL_HEALTH_FEW_TRACKS;
  if (v.starts_tried >= kStartsTried) return SEGCAL_HEALTH_NO_START;
  return v.starts_tried == 0 && v.frames > 2 * kStartFrames ? SEGCAL_HEALTH_FRAMES_TOO_FAR : SEGCAL_HEALTH_STARTING;
}

int cause(const Device<Real>& device) {
  const FaultCounts& f = device.faults();
  const VioStatistics& v = device.vio_statistics();
  const std::uint32_t refused = f.imu_stamps_back + f.imu_stamps_far + f.imu_not_finite;
  if (f.imu_samples == 0) return SEGCAL_HEALTH_NO_IMU;
  if (2 * refused > f.imu_samples) return SEGCAL_HEALTH_IMU_REFUSED;
  if (f.frames == 0) return SEGCAL_HEALTH_NO_FRAMES;
  if (2 * f.frame_stamps_far > f.frames) return SEGCAL_HEALTH_CLOCKS_APART;
  if (2 * f.frame_stamps_back > f.frames) return SEGCAL_HEALTH_FRAMES_REFUSED;
  if (v.starts == 0) return cause_before_running(f, v);
  const double seconds = static_cast<double>(f.frames_used) * static_cast<double>(device.options().frame_interval_s);
  if (v.restarts >= 2 && seconds < kRunSeconds * v.restarts) return SEGCAL_HEALTH_LOST_OFTEN;
  return 100 * static_cast<std::uint64_t>(f.imu_saturated) > f.imu_samples ? SEGCAL_HEALTH_SATURATED : SEGCAL_HEALTH_RUNNING;
}

}  // namespace
}  // namespace SEGCAL_NS

using namespace SEGCAL_NS;

extern "C" int segcal_get_health(const segcal_t* device) {
  const CDevice* d = open(device);
  return d ? cause(d->device) : SEGCAL_ERROR_STATE;
}
