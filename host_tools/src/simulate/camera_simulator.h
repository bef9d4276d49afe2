// Feature tracks: which landmarks one camera follows from frame to frame, and where it sees them.
#pragma once

#include <cstdint>
#include <optional>
#include <unordered_set>
#include <vector>

#include "../calibration_file.h"
#include "imu_simulator.h"
#include "random.h"
#include "scene.h"

namespace host::sim {

struct TrackOptions {
  int count = 60;                  ///< tracks alive at a time, as far as the view offers them
  int shortest = 6, longest = 45;  ///< life span of a track, frames
  std::vector<int> lives = {};    ///< life spans to draw from, as often as they are listed; empty: evenly between these
  double pixel_noise_px = 0.5;    ///< white, standard deviation per axis
  double walk_px_per_sqrt_s = 0;  ///< of a random walk along each track, per axis
  DepthRange depth;
};

/// As the corner tracks of a real camera (euroc_mh01): hardly
/// any white noise, most of it a random walk along the track.
inline TrackOptions drifting_tracks() {
  TrackOptions out;
  out.pixel_noise_px = 0.1;
  out.walk_px_per_sqrt_s = 0.9;
  return out;
}

/// One camera with its true calibration in the scene. Calls of `next_frame` go forward in time at a fixed rate.
class CameraSimulator {
 public:
  /// `period` in s between frames; it is used to look ahead, so
  /// that no track begins that could not live `shortest` frames.
  CameraSimulator(const CameraCalibration& camera, std::size_t index, const Trajectory& truth,
                  const std::vector<Eigen::Vector3d>& scene, const Effects& effects, const TrackOptions& options,
                  double period, std::uint64_t seed, const WarmUp& warm_up = no_warm_up());

  /// From now on landmarks that `first`, the rig's first camera, follows at the time are preferred, under its ids.
  /// `first` must outlive this and make each frame before.
  void match_with(const CameraSimulator* first) { first_camera_ = first; }

  /// Tracks of the frame at `t`, s since the first frame. New ids are taken from `next_track_id`.
  std::vector<TrackPoint> next_frame(double t, std::uint32_t& next_track_id);

 private:
  struct Track {
    std::uint32_t id;
    std::size_t landmark;
    int frames_left;
    Eigen::Vector2d pixel;         ///< without noise, so that the noise has no say in which tracks begin
    Eigen::Vector2d walked{0, 0};  ///< px, drift since the track began
  };
  struct Sighting {
    std::size_t landmark;
    Eigen::Vector2d pixel;
  };

  std::optional<Eigen::Vector2d> observe(const BodyState& state, double t, const Eigen::Vector3d& landmark_G) const;
  std::optional<Eigen::Vector2d> project_from(const CameraCalibration& camera, const BodyState& state,
                                              const Eigen::Vector3d& landmark_G, double border) const;
  Eigen::Vector2d moved(const CameraCalibration& camera, double t, Eigen::Vector2d pixel) const;
  bool folds_back(const CameraCalibration& camera, double t, const Eigen::Vector2d& pixel) const;
  CameraCalibration camera_at(double t) const;
  bool stays_visible(std::size_t landmark) const;
  std::vector<Sighting> free_sightings(double t);
  void continue_tracks(double t, std::vector<TrackPoint>& points);
  void start_tracks(double t, std::uint32_t& next_track_id, std::vector<TrackPoint>& points);
  const Track* matched_track(std::size_t landmark) const;
  std::uint32_t id_for(std::size_t landmark, std::uint32_t& next_track_id);
  void start_track(const Sighting& sighting, std::uint32_t id, std::vector<TrackPoint>& points);
  TrackPoint measured(const Track& track);

  CameraCalibration camera_;  ///< before any shock
  std::size_t index_;
  const Trajectory& truth_;
  const std::vector<Eigen::Vector3d>& scene_;
  const Effects& effects_;
  TrackOptions options_;
  double period_;
  WarmUp warm_up_;
  bool moves_pixels_ = false;   ///< an effect brings points into the image and takes others out of it
  double ideal_border_px_ = 0;  ///< how far from the edge the ideal pixel must be; negative: it may lie outside
  Random choices_, noise_;
  std::vector<Track> tracks_;
  const CameraSimulator* first_camera_ = nullptr;
  std::unordered_set<std::uint32_t> matched_ids_;           ///< ids of the first camera used here before
  std::vector<bool> in_use_;                                ///< per landmark
  std::vector<std::pair<double, BodyState>> states_ahead_;  ///< time and state of this frame and the next few
};

}  // namespace host::sim
