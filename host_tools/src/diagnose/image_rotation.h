// What the images say about rotation, without a map: matched rays of neighbouring frames.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "calibration_file.h"
#include "recording.h"

namespace host {

/// Rays of the corners that two neighbouring frames share, as unit vectors in C.
struct FramePair {
  double t1 = 0, t2 = 0;  ///< s since the first IMU sample, camera stamps as they are
  std::vector<Eigen::Vector3d> rays1, rays2;
  std::vector<double> lines1, lines2;  ///< of each corner: rows from the middle one, or columns (`readout`)
};

/// Pairs of frames 40 to 250 ms apart with at least 12 common corners.
std::vector<FramePair> frame_pairs(const Recording& recording, const CameraCalibration& camera);

/// Angular rate of the camera in C, rad/s, as if the device only turned (Wahba, robust): translation past near points
/// adds to it, a tenth or two of a rad/s.
Eigen::Vector3d rate_by_rotation_alone(const FramePair& pair);

/// How badly the rays fit the rotation R_12 (a ray of frame 2 into frame 1), whatever the translation: the smallest
/// eigenvalue of the sum of n n^T with n = ray1 x R_12 ray2 (Kneip and Lynen, "Direct optimization of frame-to-frame
/// rotation", ICCV 2013). rad^2, grows by the pixel noise squared per corner.
double misfit(const FramePair& pair, const Eigen::Matrix3d& R_12);

}  // namespace host
