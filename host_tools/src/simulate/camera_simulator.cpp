#include "camera_simulator.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "camera_model.h"

namespace host::sim {
namespace {

constexpr double border_px = 3;     // so that noise does not carry a corner out of the image
constexpr double least_area = 0.1;  // of a pixel, as effects image it, over what it was
constexpr double beyond_px = 200;   // where a lens may still bring points into the image that its model has outside
constexpr std::size_t grid_columns = 8, grid_rows = 6;

/// Counts tracks per cell of the image, so that new ones fill the empty places first.
class Coverage {
 public:
  explicit Coverage(const CameraCalibration& camera) : width_(camera.width), height_(camera.height) {}
  int& at(const Eigen::Vector2d& pixel) {
    const auto column = static_cast<std::size_t>(std::clamp(pixel.x() / width_, 0.0, 0.999) * grid_columns);
    const auto row = static_cast<std::size_t>(std::clamp(pixel.y() / height_, 0.0, 0.999) * grid_rows);
    return counts_[row * grid_columns + column];
  }

 private:
  double width_, height_;
  std::array<int, grid_columns * grid_rows> counts_{};
};

}  // namespace

CameraSimulator::CameraSimulator(const CameraCalibration& camera, std::size_t index, const Trajectory& truth,
                                 const std::vector<Eigen::Vector3d>& scene, const Effects& effects,
                                 const TrackOptions& options, double period, std::uint64_t seed, const WarmUp& warm_up)
    : camera_(camera),
      index_(index),
      truth_(truth),
      scene_(scene),
      effects_(effects),
      options_(options),
      period_(period),
      warm_up_(warm_up),
      choices_(seed, Stream::tracks),
      noise_(seed, Stream::pixels),
      in_use_(scene.size(), false) {
  moves_pixels_ = std::any_of(effects.begin(), effects.end(), [](const auto& e) { return e->moves_pixels(); });
  ideal_border_px_ = moves_pixels_ ? -beyond_px : border_px;
}

std::optional<Eigen::Vector2d> CameraSimulator::project_from(const CameraCalibration& camera, const BodyState& state,
                                                             const Eigen::Vector3d& landmark_G, double border) const {
  const Eigen::Vector3d p_I = state.R_GI.transpose() * (landmark_G - state.p_GI);
  const Eigen::Vector3d p_C = camera.R_CI * p_I + camera.p_CI;
  const double distance = p_C.norm();
  if (distance < options_.depth.near || distance > options_.depth.far) return std::nullopt;
  return project(camera, p_C, border);
}

CameraCalibration CameraSimulator::camera_at(double t) const {
  CameraCalibration camera = camera_;
  for (const auto& effect : effects_) effect->on_camera_calibration({t, index_, warm_up_.at(t)}, camera);
  return camera;
}

/// All effects on the camera act here. The line decides when a pixel is exposed, and the pose at that time decides the
/// line: two rounds are plenty, the motion during the read-out is small.
std::optional<Eigen::Vector2d> CameraSimulator::observe(const BodyState& state, double t,
                                                        const Eigen::Vector3d& landmark_G) const {
  if (effects_.empty()) return project_from(camera_, state, landmark_G, border_px);
  const CameraCalibration camera = camera_at(t);
  std::optional<Eigen::Vector2d> pixel = project_from(camera, state, landmark_G, ideal_border_px_);
  for (int round = 0; round < 3 && pixel; ++round) {
    double t_exposed = t;
    for (const auto& effect : effects_) t_exposed = effect->exposure_time(camera, t_exposed, camera.line_of(*pixel));
    pixel = project_from(camera, truth_.at(t_exposed), landmark_G, ideal_border_px_);
  }
  if (!pixel) return pixel;
  if (!moves_pixels_) return pixel;
  const Eigen::Vector2d seen = moved(camera, t, *pixel);
  if (!is_inside(camera, seen, border_px) || folds_back(camera, t, *pixel)) return std::nullopt;
  return seen;
}

Eigen::Vector2d CameraSimulator::moved(const CameraCalibration& camera, double t, Eigen::Vector2d pixel) const {
  for (const auto& effect : effects_) effect->on_pixel(camera, t, pixel);
  return pixel;
}

/// A polynomial of the lens ends where it would image a second ray to the same place: no lens goes on there.
bool CameraSimulator::folds_back(const CameraCalibration& camera, double t, const Eigen::Vector2d& pixel) const {
  Eigen::Matrix2d by_pixel;
  for (int i = 0; i < 2; ++i) {
    const Eigen::Vector2d half = 0.5 * Eigen::Vector2d::Unit(i);
    by_pixel.col(i) = moved(camera, t, pixel + half) - moved(camera, t, pixel - half);
  }
  return by_pixel.determinant() < least_area || by_pixel.trace() < 0;  // a fold in each direction mirrors
}

std::vector<TrackPoint> CameraSimulator::next_frame(double t, std::uint32_t& next_track_id) {
  states_ahead_.clear();
  for (int k = 0; k < options_.shortest; ++k) states_ahead_.emplace_back(t + k * period_, truth_.at(t + k * period_));
  std::vector<TrackPoint> points;
  continue_tracks(t, points);
  start_tracks(t, next_track_id, points);
  return points;
}

void CameraSimulator::continue_tracks(double t, std::vector<TrackPoint>& points) {
  std::vector<Track> alive;
  for (Track track : tracks_) {
    std::optional<Eigen::Vector2d> pixel;
    if (track.frames_left > 0) pixel = observe(states_ahead_.front().second, t, scene_[track.landmark]);
    in_use_[track.landmark] = pixel.has_value();
    if (!pixel) continue;
    --track.frames_left;
    track.pixel = *pixel;
    if (options_.walk_px_per_sqrt_s > 0) {
      const double step = options_.walk_px_per_sqrt_s * std::sqrt(period_);
      for (double& walked : track.walked) walked += step * noise_.normal();
    }
    alive.push_back(track);
    points.push_back(measured(track));
  }
  tracks_ = std::move(alive);
}

/// Landmarks in view that no track follows, in random order.
std::vector<CameraSimulator::Sighting> CameraSimulator::free_sightings(double t) {
  std::vector<Sighting> sightings;
  for (std::size_t i = 0; i < scene_.size(); ++i) {
    if (in_use_[i]) continue;
    if (const auto pixel = observe(states_ahead_.front().second, t, scene_[i])) sightings.push_back({i, *pixel});
  }
  for (std::size_t i = sightings.size(); i > 1; --i)
    std::swap(sightings[i - 1], sightings[static_cast<std::size_t>(choices_.integer(0, static_cast<int>(i) - 1))]);
  if (first_camera_) {
    std::stable_partition(sightings.begin(), sightings.end(),
                          [this](const Sighting& s) { return matched_track(s.landmark) != nullptr; });
  }
  return sightings;
}

/// The first camera's track of a landmark, if it has one that was no track here yet.
const CameraSimulator::Track* CameraSimulator::matched_track(std::size_t landmark) const {
  if (!first_camera_ || !first_camera_->in_use_[landmark]) return nullptr;
  for (const Track& track : first_camera_->tracks_) {
    if (track.landmark == landmark) return matched_ids_.count(track.id) == 0 ? &track : nullptr;
  }
  return nullptr;
}

std::uint32_t CameraSimulator::id_for(std::size_t landmark, std::uint32_t& next_track_id) {
  const Track* const matched = matched_track(landmark);
  if (!matched) return next_track_id++;
  matched_ids_.insert(matched->id);
  return matched->id;
}

bool CameraSimulator::stays_visible(std::size_t landmark) const {
  return std::all_of(states_ahead_.begin(), states_ahead_.end(), [&](const auto& ahead) {
    return observe(ahead.second, ahead.first, scene_[landmark]).has_value();
  });
}

void CameraSimulator::start_tracks(double t, std::uint32_t& next_track_id, std::vector<TrackPoint>& points) {
  const auto wanted = static_cast<std::size_t>(options_.count);
  if (tracks_.size() >= wanted) return;
  Coverage coverage(camera_);
  for (const Track& track : tracks_) ++coverage.at(track.pixel);
  std::vector<Sighting> candidates = free_sightings(t);
  // First the empty cells, then those with one track, and so on.
  for (int level = 0; level < options_.count && tracks_.size() < wanted && !candidates.empty(); ++level) {
    std::vector<Sighting> later;
    for (const Sighting& sighting : candidates) {
      if (tracks_.size() >= wanted) break;
      int& count = coverage.at(sighting.pixel);
      if (count > level) {
        later.push_back(sighting);
      } else if (stays_visible(sighting.landmark)) {
        ++count;
        start_track(sighting, id_for(sighting.landmark, next_track_id), points);
      }
    }
    candidates = std::move(later);
  }
}

void CameraSimulator::start_track(const Sighting& sighting, std::uint32_t id, std::vector<TrackPoint>& points) {
  const std::vector<int>& lives = options_.lives;
  const int life = lives.empty()
                       ? choices_.integer(options_.shortest, options_.longest)
                       : lives[static_cast<std::size_t>(choices_.integer(0, static_cast<int>(lives.size()) - 1))];
  tracks_.push_back({id, sighting.landmark, life - 1, sighting.pixel, {0, 0}});
  in_use_[sighting.landmark] = true;
  points.push_back(measured(tracks_.back()));
}

TrackPoint CameraSimulator::measured(const Track& track) {
  const Eigen::Vector2d pixel = track.pixel + track.walked;
  const double u = pixel.x() + options_.pixel_noise_px * noise_.normal();
  const double v = pixel.y() + options_.pixel_noise_px * noise_.normal();
  return {track.id, u, v};
}

}  // namespace host::sim
