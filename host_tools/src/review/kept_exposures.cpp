#include "review/kept_exposures.h"

#include <algorithm>

#include "diagnose/exposure_offset.h"
#include "review/linearised.h"
#include "stamps/exposures.h"

namespace host::review {
namespace {

bool is_of(const CoreKept& kept, const std::vector<Recording>& sessions) {
  if (kept.segment.session >= sessions.size()) return false;
  const std::vector<Frame>& frames = sessions[kept.segment.session].cameras.front().frames;
  return frames.front().t_ns <= kept.segment.start_ns && kept.segment.end_ns <= frames.back().t_ns;
}

}  // namespace

std::vector<double> kept_exposures(const ReplayResult& result, const std::vector<Recording>& sessions) {
  if (!std::all_of(sessions.begin(), sessions.end(), has_exposures)) return {};
  std::vector<CoreKept> kept;
  for (const CoreKept* k : in_order(result)) {
    if (!is_of(*k, sessions)) return {};
    kept.push_back(*k);
  }
  return diagnosis::mean_exposures(kept, sessions);
}

}  // namespace host::review
