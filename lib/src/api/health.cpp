// What keeps the odometry from running: the first cause that the counters show.
#include "api/handle.h"

namespace SEGCAL_NS {
namespace {

/// Starts in motion without success after which the motion is not to blame: hands, feet and vehicles start within them
/// (in 2 s, 19 of 20 simulated recordings; where a try takes its time, in 7 s, four of five).
constexpr std::int32_t kStartsTried = SEGCAL_START_DELAY_MS > 0 ? 5 : 20;
/// s that the filter should run without being lost: as long as two segments.
constexpr double kRunSeconds = 10;

/// Spikes so near to each other, s, and more than a few, leave no segment whole.
constexpr Real kSpikeSeconds = Real(4);
constexpr std::uint32_t kFewSpikes = 2;

/// Too few to judge by; and too few to judge a share of.
constexpr std::uint32_t kFewSegments = 4;
constexpr std::uint32_t kFewFrames = 2 * kStartFrames, kFewSamples = 100;

bool most(std::uint32_t some, std::uint32_t all, std::uint32_t few) { return all > few && some > all / 2; }

/// Why no good frame has been used since the last one, from what came since then; RUNNING where that is no reason.
int cause_in_stream(const StreamCounts& now, const StreamCounts& then, Real imu_rate_hz) {
  const std::uint32_t imu = now.imu - then.imu, frames = now.frames - then.frames;
  if (now.imu == 0 || (frames > kFewFrames && imu < frames)) return SEGCAL_HEALTH_NO_IMU;
  if (most(now.imu_refused - then.imu_refused, imu, kFewSamples)) return SEGCAL_HEALTH_IMU_REFUSED;
  if (most(now.imu_saturated - then.imu_saturated, imu, kFewSamples)) return SEGCAL_HEALTH_SATURATED;
  if (most(now.imu_gaps - then.imu_gaps, imu, kFewSamples)) return SEGCAL_HEALTH_IMU_RATE;
  if (now.frames == 0 || (frames == 0 && static_cast<Real>(imu) > static_cast<Real>(kRunSeconds) * imu_rate_hz))
    return SEGCAL_HEALTH_NO_FRAMES;
  if (most(now.frames_far - then.frames_far, frames, kFewFrames)) return SEGCAL_HEALTH_CLOCKS_APART;
  if (most(now.frames_back - then.frames_back, frames, kFewFrames)) return SEGCAL_HEALTH_FRAMES_REFUSED;
  return most(now.frames_few - then.frames_few, frames, kFewFrames) ? SEGCAL_HEALTH_FEW_TRACKS : SEGCAL_HEALTH_RUNNING;
}

/// Averages of samples are made, and the history is as long, as the
/// stated rate wants it. Half as fast again is no clock's error.
bool faster_than_stated(const Device<Real>& device) {
  const ImuHistory<Real>& imu = device.imu_history();
  if (imu.size() < 2) return false;
  const Real seconds = static_cast<Real>(imu.newest() - imu.oldest()) * Real(1e-9);
  return static_cast<Real>((imu.size() - 1) * device.options().imu_group) >
         Real(1.5) * seconds * device.options().imu_rate_hz;
}

/// Of frames that wait for a start, since the filter ran last.
int cause_of_waiting(const VioStatistics& v, bool faster) {
  if (v.starts_tried >= kStartsTried)
    return v.late_starts < v.starts_tried ? SEGCAL_HEALTH_NO_START : SEGCAL_HEALTH_STARTS_LATE;
  if (v.frames_waited <= 2 * kStartFrames || v.starts_tried > 0) return SEGCAL_HEALTH_STARTING;
  return faster ? SEGCAL_HEALTH_IMU_RATE : SEGCAL_HEALTH_FRAMES_TOO_FAR;
}

int cause(const Device<Real>& device) {
  const FaultCounts& f = device.faults();
  const VioStatistics& v = device.vio_statistics();
  const int stream = cause_in_stream(StreamCounts(f), device.counts_at_last_use(), device.options().imu_rate_hz);
  if (stream != SEGCAL_HEALTH_RUNNING) return stream;
  const Real samples_between = kSpikeSeconds * device.options().imu_rate_hz;
  if (device.imu_spikes() > kFewSpikes && samples_between * Real(device.imu_spikes()) > Real(f.imu_samples))
    return SEGCAL_HEALTH_SPIKES;
  const double seconds = static_cast<double>(f.frames_used) * static_cast<double>(device.frame_distance_s());
  const bool lost_often = v.restarts >= 2 && seconds < kRunSeconds * v.restarts;
  if (lost_often || !device.odometry_runs()) {
    if (most(device.frames_crowded_out(), f.frames, kFewFrames)) return SEGCAL_HEALTH_FRAMES_CROWDED;
    return lost_often ? SEGCAL_HEALTH_LOST_OFTEN : cause_of_waiting(v, faster_than_stated(device));
  }
  if (f.imu_saturated > f.imu_samples / 100) return SEGCAL_HEALTH_SATURATED;
  const bool none_useful =
      f.segments_closed > kFewSegments && f.segments_discarded + f.segments_unsettled >= f.segments_closed - 1;
  return none_useful ? SEGCAL_HEALTH_NO_SEGMENTS : SEGCAL_HEALTH_RUNNING;  // one may wait for its score
}

}  // namespace
}  // namespace SEGCAL_NS

using namespace SEGCAL_NS;

extern "C" [[gnu::cold]] int segcal_get_health(const segcal_t* device) {
  const CDevice* d = open(device);
  return d ? cause(d->device) : SEGCAL_ERROR_STATE;
}
