#include "replay/counters.h"

#include <set>

namespace host {

Counters difference(Counters now, const Counters& before) {
  for (std::size_t i = 0; i < now.size(); ++i) now[i].second -= before[i].second;
  return now;
}

void count_strays(const std::vector<Recording>& sessions, Counters* counters) {
  std::uint32_t n = 0;
  for (const Recording& session : sessions) {
    std::set<std::int64_t> stamps;
    for (const CameraData& camera : session.cameras)
      for (const Frame& frame : camera.strays) stamps.insert(frame.t_ns);
    n += static_cast<std::uint32_t>(stamps.size());
  }
  for (auto& [name, count] : *counters)
    if (name == "frames" || name == "frame_stamps_far") count += n;
}

}  // namespace host
