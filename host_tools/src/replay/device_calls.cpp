// A recording as the calls that a device would have had.
#include "replay/replay.h"

namespace host {

std::vector<RigFrame> rig_frames(const Recording& recording) {
  const std::size_t n = recording.cameras.size();
  std::vector<RigFrame> out;
  for (const Frame& frame : recording.cameras[0].frames) {
    out.push_back({frame.t_ns, std::vector<const Frame*>(n, nullptr)});
    out.back().cameras[0] = &frame;
  }
  for (std::size_t c = 1; c < n; ++c) {
    std::size_t at = 0;
    for (const Frame& frame : recording.cameras[c].frames) {
      if (recording.device) {
        out[at++].cameras[c] = &frame;
        continue;
      }
      while (at < out.size() && (out[at].t_ns < frame.t_ns || (out[at].t_ns == frame.t_ns && out[at].cameras[c]))) ++at;
      if (at == out.size() || out[at].t_ns != frame.t_ns) {
        out.insert(out.begin() + static_cast<std::ptrdiff_t>(at), {frame.t_ns, std::vector<const Frame*>(n, nullptr)});
      }
      out[at].cameras[c] = &frame;
    }
  }
  return out;
}

std::vector<DeviceCall> calls_of(const Recording& recording, const std::vector<RigFrame>& frames) {
  if (recording.device) return recording.device->calls;
  std::vector<DeviceCall> calls;
  const std::vector<ImuSample>& samples = recording.imu.samples;
  std::size_t next = 0;
  for (const RigFrame& frame : frames) {
    bool reached = false;
    while (next < samples.size() && !reached) {
      reached = samples[next++].t_ns >= frame.t_ns;
      calls.push_back({DeviceCall::sample, 0});
    }
    calls.push_back({DeviceCall::frame, 0});
  }
  return calls;
}

}  // namespace host
