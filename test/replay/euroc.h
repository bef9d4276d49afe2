// The real recording euroc_mh01 (Burri et al., IJRR 2016), where it is at hand: its tracks, disturbed starts, and how
// far a trajectory is from the published one.
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <random>
#include <string>
#include <vector>

#include "replay/replay.h"

namespace test::euroc {

constexpr std::int64_t kFirstImuNs = 1403636579758555392;  ///< sequence time 0
constexpr double kStandsFrom = 20.5;                       ///< s of sequence time: put on the floor
constexpr double kShakenFrom = 31.3;                       ///< s: shaken by up to 0.1 rad/s, still on the floor

inline double sequence_time(std::int64_t t_ns) { return static_cast<double>(t_ns - kFirstImuNs) * 1e-9; }

/// Makes the tracks with the program, as a user does, in `folder`. They do not depend on the start that is tried later:
/// this one only serves to reject outliers.
inline host::Recording tracked(const std::filesystem::path& data, const std::filesystem::path& start,
                               const std::filesystem::path& folder, int cameras = 1) {
  const std::string command = std::string("\"") + SEGCAL_PROGRAM + "\" track \"" + (data / "euroc_mh01").string() +
                              "\" --calib \"" + start.string() + "\" --out \"" + folder.string() +
                              "\" > /dev/null 2>&1";
  if (std::system(command.c_str()) != 0) throw host::InputError("this failed: " + command);
  return host::read_recording(folder, cameras);
}

/// A start as far off the published calibration as the one in fixtures/, in a random direction: 2 % in f, 10 px in c,
/// 1.7 deg, 27 mm, and the same wrong distortion; each camera in a direction of its own.
inline host::Calibration disturbed(const host::Calibration& published, unsigned seed) {
  std::mt19937 bits(seed);
  const auto uniform = [&bits](double low, double high) { return low + (high - low) * (bits() / 4294967296.0); };
  const auto direction = [&uniform] {
    const double z = uniform(-1, 1), a = uniform(-M_PI, M_PI), r = std::sqrt(1 - z * z);
    return Eigen::Vector3d(r * std::cos(a), r * std::sin(a), z);
  };
  host::Calibration out = published;
  for (host::CameraCalibration& camera : out.cameras) {
    const double f = uniform(0, 1) < 0.5 ? 0.98 : 1.02, a = uniform(-M_PI, M_PI);
    camera.intrinsics.head<2>() *= f;
    camera.intrinsics.tail<2>() += 10 * Eigen::Vector2d(std::cos(a), std::sin(a));
    camera.distortion = {-0.24, 0.05, 0, 0};
    camera.R_CI = Eigen::AngleAxisd(1.7 * M_PI / 180, direction()).toRotationMatrix() * camera.R_CI;
    camera.p_CI += 0.027 * direction();
  }
  return out;
}

/// How far a camera is from what is published.
struct CameraError {
  double f, c, R_CI, p_CI;  ///< share, px, rad, m
};

inline CameraError camera_error(const host::CameraCalibration& camera, const host::CameraCalibration& published) {
  const Eigen::Vector2d ratio = camera.intrinsics.head<2>().cwiseQuotient(published.intrinsics.head<2>());
  return {(ratio - Eigen::Vector2d::Ones()).cwiseAbs().maxCoeff(),
          (camera.intrinsics - published.intrinsics).tail<2>().cwiseAbs().maxCoeff(),
          Eigen::AngleAxisd(camera.R_CI * published.R_CI.transpose()).angle(), (camera.p_CI - published.p_CI).norm()};
}

/// Place of cam0 seen from cam1, in cam1's axes, m.
inline Eigen::Vector3d baseline(const host::Calibration& calibration) {
  const host::CameraCalibration &first = calibration.cameras[0], &second = calibration.cameras[1];
  return second.p_CI - second.R_CI * first.R_CI.transpose() * first.p_CI;
}

/// The published position at a stamp, between its neighbours; false outside.
inline bool true_position(const std::vector<host::TruthPose>& truth, std::int64_t t_ns, Eigen::Vector3d* out) {
  const auto after = std::lower_bound(truth.begin(), truth.end(), t_ns,
                                      [](const host::TruthPose& pose, std::int64_t t) { return pose.t_ns < t; });
  if (after == truth.begin() || after == truth.end()) return false;
  const auto before = after - 1;
  const double share = static_cast<double>(t_ns - before->t_ns) / static_cast<double>(after->t_ns - before->t_ns);
  for (std::size_t i = 0; i < 3; ++i) {
    (*out)[static_cast<Eigen::Index>(i)] = (1 - share) * before->p_GI[i] + share * after->p_GI[i];
  }
  return true;
}

/// Root mean square distance, m, after the best yaw and shift: what an odometry cannot know.
inline double aligned_rmse(const std::vector<Eigen::Vector3d>& estimate, const std::vector<Eigen::Vector3d>& truth) {
  Eigen::Vector3d centre_e = Eigen::Vector3d::Zero(), centre_t = Eigen::Vector3d::Zero();
  const double n = static_cast<double>(estimate.size());
  for (std::size_t i = 0; i < estimate.size(); ++i) {
    centre_e += estimate[i] / n;
    centre_t += truth[i] / n;
  }
  double sine = 0, cosine = 0;
  for (std::size_t i = 0; i < estimate.size(); ++i) {
    const Eigen::Vector3d e = estimate[i] - centre_e, t = truth[i] - centre_t;
    sine += e.x() * t.y() - e.y() * t.x();
    cosine += e.x() * t.x() + e.y() * t.y();
  }
  const Eigen::AngleAxisd yaw(std::atan2(sine, cosine), Eigen::Vector3d::UnitZ());
  double sum = 0;
  for (std::size_t i = 0; i < estimate.size(); ++i) {
    sum += (yaw * (estimate[i] - centre_e) - (truth[i] - centre_t)).squaredNorm();
  }
  return std::sqrt(sum / n);
}

/// While the vehicle moves.
inline double moving_rmse(const std::vector<host::CoreState>& trajectory, const std::vector<host::TruthPose>& truth) {
  std::vector<Eigen::Vector3d> estimate, published;
  for (const host::CoreState& state : trajectory) {
    Eigen::Vector3d p;
    if (sequence_time(state.t_ns) >= kStandsFrom || !true_position(truth, state.t_ns, &p)) continue;
    estimate.push_back(state.p_GI);
    published.push_back(p);
  }
  return aligned_rmse(estimate, published);
}

/// Farthest from where it stood first, m.
inline double standing_drift(const std::vector<host::CoreState>& trajectory) {
  const host::CoreState* first = nullptr;
  double farthest = 0;
  for (const host::CoreState& state : trajectory) {
    if (sequence_time(state.t_ns) < kStandsFrom) continue;
    if (!first) first = &state;
    farthest = std::max(farthest, (state.p_GI - first->p_GI).norm());
  }
  return farthest;
}

}  // namespace test::euroc
