#include "experiments/soak_sessions.h"

#include <algorithm>
#include <vector>

#include "simulate/fault_kinds.h"

namespace host::experiments {
namespace {

using sim::FaultKind, sim::fault_kinds;

constexpr double fault_share = 1.0 / 15;  // of a session
/// Two faults in a session, at these shares of it; the later one first, since stamps before it must be in order.
constexpr double fault_places[] = {0.65, 0.25};

/// Those that a stretch of a session may have. A bias that steps is
/// seen by the review of a replay alone, and a soak has a device.
const std::vector<const FaultKind*>& passing_faults() {
  static const std::vector<const FaultKind*> kinds = [] {
    std::vector<const FaultKind*> out;
    for (const FaultKind& kind : fault_kinds())
      if (!kind.names.empty() && kind.effect.empty() && kind.names.front() != "bias_step") out.push_back(&kind);
    return out;
  }();
  return kinds;
}

/// Takes what lies in [begin, end) out of `from`, changes it with `change`, and puts it back.
template <class Stamped, class Change>
void change_piece(std::vector<Stamped>& from, std::int64_t begin_ns, std::int64_t end_ns, const Change& change) {
  const auto before = [](const Stamped& s, std::int64_t t) { return s.t_ns < t; };
  const auto first = std::lower_bound(from.begin(), from.end(), begin_ns, before),
             last = std::lower_bound(first, from.end(), end_ns, before);
  const std::vector<Stamped> piece = change(std::vector<Stamped>(first, last));
  from.insert(from.erase(first, last), piece.begin(), piece.end());
}

void spoil_piece(Recording& r, double place, const FaultKind& kind, std::uint64_t seed) {
  const double length = static_cast<double>(r.imu.samples.back().t_ns - r.imu.samples.front().t_ns);
  const std::int64_t begin = r.imu.samples.front().t_ns + static_cast<std::int64_t>(place * length);
  const std::int64_t end = begin + static_cast<std::int64_t>(fault_share * length);
  Recording piece;
  piece.imu.noise = r.imu.noise;
  piece.cameras.resize(1);
  change_piece(r.imu.samples, begin, end, [&](const auto& p) { return piece.imu.samples = p; });
  change_piece(r.cameras[0].frames, begin, end, [&](const auto& p) { return piece.cameras[0].frames = p; });
  kind.spoil(piece, seed);
  change_piece(r.imu.samples, begin, end, [&](const auto&) { return piece.imu.samples; });
  change_piece(r.cameras[0].frames, begin, end, [&](const auto&) { return piece.cameras[0].frames; });
}

}  // namespace

SimulationResult soak_session(std::uint64_t seed, int index, double seconds) {
  SimulationOptions options;
  options.scenario = index % 4 < 2 ? "rich" : "arvr";
  options.seconds = seconds;
  options.seed = seed * 100000 + static_cast<std::uint64_t>(index);
  options.device_seed = seed;
  SimulationResult session = simulate(options);
  if (index % 2 == 0) return session;
  const auto& kinds = passing_faults();
  for (std::size_t i = 0; i < std::size(fault_places); ++i) {
    const std::size_t which = (seed + static_cast<std::size_t>(index / 2) * std::size(fault_places) + i) % kinds.size();
    spoil_piece(session.recording, fault_places[i], *kinds[which], options.seed);
  }
  return session;
}

}  // namespace host::experiments
