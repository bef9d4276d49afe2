// A device log written with one profile's C API. Compiled once per profile, as core_of_profile.cpp.
#include "replay/profile/config_of_profile.h"
#include "replay/replay.h"
#include "segcal/log.h"

namespace host {
namespace SEGCAL_NS {

int append(void* context, const void* bytes, std::size_t n) {
  auto* out = static_cast<std::vector<std::uint8_t>*>(context);
  const auto* first = static_cast<const std::uint8_t*>(bytes);
  out->insert(out->end(), first, first + n);
  return 0;
}

void log_session(const Recording& recording, segcal_log_t* log) {
  const std::vector<RigFrame> frames = rig_frames(recording);
  std::vector<DeviceCall> calls = calls_of(recording, frames);
  if (!recording.device) {
    calls.push_back({DeviceCall::flush, 0});
    calls.push_back({DeviceCall::calibrate, 0});
  }
  std::size_t sample = 0, frame = 0;
  std::vector<segcal_point_t> points;
  for (const DeviceCall& call : calls) {
    switch (call.what) {
      case DeviceCall::sample: {
        const segcal_imu_t s = sample_to_c(recording.imu.samples[sample++]);
        segcal_log_imu(log, &s);
        break;
      }
      case DeviceCall::frame:
        points_to_c(frames[frame].cameras, &points);
        segcal_log_tracks(log, frames[frame++].t_ns, points.data(), static_cast<int>(points.size()));
        break;
      case DeviceCall::flush: segcal_log_mark(log, SEGCAL_LOG_FLUSH); break;
      case DeviceCall::request: segcal_log_mark(log, SEGCAL_LOG_REQUEST_CALIBRATION); break;
      case DeviceCall::calibrate: segcal_log_mark(log, SEGCAL_LOG_CALIBRATE); break;
      case DeviceCall::hash: segcal_log_hash(log, call.hash_value); break;
    }
    if (call.late) segcal_log_mark(log, SEGCAL_LOG_LATE);
  }
}

std::vector<std::uint8_t> log_of(const std::vector<Recording>& sessions, const CoreOptions& options) {
  std::vector<std::uint8_t> out, block(SEGCAL_LOG_BLOCK_BYTES);
  const segcal_config_t config = config_of(options);
  segcal_log_t log;
  if (segcal_log_begin(&log, &config, block.data(), block.size(), append, &out) != SEGCAL_OK) {
    throw InputError("the configuration does not fit into a device log");
  }
  for (std::size_t i = 0; i < sessions.size(); ++i) {
    if (i > 0) segcal_log_mark(&log, SEGCAL_LOG_NEW_SESSION);
    log_session(sessions[i], &log);
  }
  segcal_log_end(&log);
  return out;
}

}  // namespace SEGCAL_NS

}  // namespace host
