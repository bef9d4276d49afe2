// The same corners in two cameras of a rig, so that their landmarks tie the cameras together.
#pragma once

#include "feature_tracker.h"

namespace host {

/// Looks for the first camera's corners in the second camera's image of the same moment: Lucas-Kanade there and back
/// from where a far point would be, then RANSAC. What is found is a track of the second camera with the same
/// identifier, followed there on its own. Pairs that no longer agree with the others' epipolar geometry are parted.
class StereoMatcher {
 public:
  explicit StereoMatcher(const TrackerOptions& options) : options_(options) {}

  /// After both cameras have followed their tracks into images of the same stamp.
  void match(const FeatureTracker& first, FeatureTracker& second) const;

 private:
  struct Pairs {
    std::vector<Track> first, second;
  };
  Pairs known_pairs(const FeatureTracker& first, const FeatureTracker& second) const;
  void add_new_pairs(const FeatureTracker& first, const FeatureTracker& second, Pairs& pairs) const;

  TrackerOptions options_;
};

}  // namespace host
