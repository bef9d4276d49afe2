// The problem of a replay's calibration: from kept segments to a reference problem.
#include <map>
#include <numeric>

#include "reference/finish.h"

namespace host {
namespace reference {
namespace {

/// Which segments stand in one frame.
class Sets {
 public:
  explicit Sets(std::size_t n) : parent_(n) { std::iota(parent_.begin(), parent_.end(), std::size_t{0}); }
  std::size_t root(std::size_t i) const { return parent_[i] == i ? i : root(parent_[i]); }
  void join(std::size_t a, std::size_t b) {
    const std::size_t first = std::min(root(a), root(b)), last = std::max(root(a), root(b));
    parent_[last] = first;
  }

 private:
  std::vector<std::size_t> parent_;
};

struct KeptBuilder {
  Problem problem;
  Sets frames;
  std::map<int, std::pair<int, std::size_t>> tie;  ///< number: landmark, first segment

  explicit KeptBuilder(const KeptSegments& kept) : frames(kept.segments.size()) {
    problem.model = kept.model;
    for (std::size_t i = 0; i < kept.segments.size(); ++i) add(kept.segments[i], i);
    for (std::size_t i = 0; i < kept.segments.size(); ++i) {
      if (frames.root(i) == i) problem.gauges.push_back(first_state_[i]);
    }
  }

 private:
  void add(const CoreKept& segment, std::size_t i) {
    const int first = static_cast<int>(problem.states.size()), samples = static_cast<int>(problem.samples.size());
    first_state_.push_back(first);
    problem.samples.push_back(segment.samples);
    for (const CoreState& x : segment.keyframes) problem.states.push_back(state_of(x));
    problem.segment_starts.push_back(first);
    if (segment.join == "none") problem.chain_starts.push_back(first);
    if (segment.join == "bias") problem.walks.push_back({first - 1, first, segment.gap_s});
    if (segment.join == "imu") {
      problem.links.push_back({first - 1, first, samples});
      frames.join(i - 1, i);
    }
    for (int k = 1; k < static_cast<int>(segment.keyframes.size()); ++k)
      problem.links.push_back({first + k - 1, first + k, samples});
    std::vector<int> index;
    for (const CoreLandmark& l : segment.landmarks) index.push_back(landmark_of(l, i, segment.turned_only));
    for (const CorePoint& z : segment.measured) {
      problem.points.push_back({first + z.keyframe,
                                index[static_cast<std::size_t>(z.landmark)],
                                z.camera,
                                {z.u, z.v},
                                z.rejected,
                                static_cast<int>(i)});
    }
  }

  /// A tie is one landmark for all segments that see it, and puts them into one frame.
  int landmark_of(const CoreLandmark& l, std::size_t segment, bool turned_only) {
    const int next = static_cast<int>(problem.landmarks.size());
    if (l.tie >= 0) {
      const auto [at, is_new] = tie.try_emplace(l.tie, next, segment);
      frames.join(at->second.second, segment);
      if (!is_new) return at->second.first;
    }
    const bool wide = turned_only && l.tie < 0;
    problem.landmarks.push_back({l.anchor, l.direction, l.inverse_distance,
                                 wide ? problem.model.turned_inverse_depth_sigma : problem.model.inverse_depth_sigma,
                                 l.tie >= 0});
    return next;
  }

  std::vector<int> first_state_;
};

}  // namespace

Problem problem_of(const KeptSegments& kept) {
  Problem problem = KeptBuilder(kept).problem;
  problem.prior_mean = kept.start;
  problem.prior_sigma = kept.prior_sigma;
  problem.scatter = kept.scatter;
  problem.theta = kept.start;
  return problem;
}

}  // namespace reference

ReferenceResult reference_segments(const KeptSegments& kept, const ReferenceOptions& options) {
  if (kept.segments.empty()) throw InputError("kept_segments.json: holds no segment; nothing was kept in that replay");
  if (!kept.effects.empty()) {
    throw InputError("kept_segments.json: that calibration estimated " + kept.effects.front() +
                     " as well, which the reference does not model; expected a replay without --enable and --model");
  }
  if (kept.condensed > 0) {
    throw InputError("kept_segments.json: " + std::to_string(kept.condensed) +
                     " more segments took part in that calibration as epochs, of which no samples and points are left "
                     "to solve it again from; expected a replay without --condense");
  }
  reference::Problem problem = reference::problem_of(kept);
  if (options.start) problem.theta = *options.start;
  ReferenceResult out = reference::finish(&problem, options);
  out.result.segments = static_cast<int>(kept.segments.size());
  out.noise = kept.noise;
  return out;
}

}  // namespace host
