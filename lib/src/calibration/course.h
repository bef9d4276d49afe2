// How did theta change over sessions: not at all but for the changes that were decided, by a step that was too small to
// be noticed, steadily with time, or with temperature?
//
// Item i (a session, or a kept segment) says |R_i (theta_i [-] theta) - d_i|^2 about the calibration theta_i that the
// device had then. Courses:
//   steps        one theta for all items between two changes
//   trend        theta + x_i v, x_i from -1 in the first session to 0 in the last
//   temperature  theta + x_i v, x_i the item's temperature less the last one's, over the range of all
//   step         theta + x_i v, x_i -1 before a session and 0 from it on
// v is of one block of theta, a lens or an axis' scale: what ages or warms up is a part. Thetas and v are Gaussian with
// the prior's sigmas, and the evidence follows from the triangle R of prior and items, columns in the prior's sigmas:
//   -2 ln p = rho^2 + 2 sum_j ln |R_jj| + 2 ln (blocks and places that were tried) + what is the same for all
// (misfit and Occam factor: MacKay, Bayesian interpolation, Neural Computation 4, 1992, section 2). Courses whose odds
// against the likeliest are better than 1 in 20 are not told apart.
//
// What is slow contradicts no single segment, and what was released is a mean over sessions then; the course says how
// far that is from what theta is now.
#pragma once

#include "calibration/history.h"

namespace SEGCAL_NS {

enum CourseForm : std::int32_t { steps_form, trend_form, temperature_form, kCourseForms };

/// ln 20: a course that is less likely than the best by more is out.
constexpr double kToldApart = 3;
/// ln 10,000: where no change was decided, another course must be likelier than a constant by as much as noise hardly
/// does (kFalseChange).
constexpr double kFalseCourse = 9.2;
/// Two sessions are a line whatever the device does.
constexpr int kLeastSessions = 3;
/// degC between the items, at least: an IMU's own heat, and how far it is from the camera's, are a few in each session.
constexpr double kLeastRange = 5;

template <class S>
struct Course {
  std::uint32_t forms = 0;       ///< bit form: not ruled out; 0: fewer than three sessions
  std::int32_t sessions = 0;     ///< that took part
  S ln_odds[kCourseForms] = {};  ///< against the likeliest; 1: not compared
  /// What rate is of, where no change or not the decided ones alone explain what came: -1: nothing.
  std::int32_t rate_form = -1;
  std::uint32_t step_session = 0;                 ///< of steps_form: the first one after it
  S rate[kMaxTheta] = {}, sigma[kMaxTheta] = {};  ///< of theta's columns, per session, per degC, or the step
  /// How far theta is from what it is now, or at the temperature that is farthest from it.
  S lag[kMaxTheta] = {};
};

/// Of a build without a history.
struct NoCourse {};

template <class S>
struct CourseItem {
  const SegmentInformation<S>* rows;
  const Calibration<S>* theta;  ///< where they are linearised
  S session, warmth;            ///< degC above 25
  std::int32_t changes;         ///< decided before it
};

/// The first item of a session that is not the `first` one; kept segments come after what was condensed.
template <class Items, class S>
bool begins_session(const Items& item, int at, S first) {
  for (int i = 0; i < at; ++i) {
    if (item(i).session == item(at).session) return false;
  }
  return item(at).session > first;
}

/// Whether an item is of the time after so many changes.
template <class Items>
bool has_level(const Items& item, int count, std::int32_t changes) {
  for (int i = 0; i < count; ++i) {
    if (item(i).changes == changes) return true;
  }
  return false;
}

/// End of the block of theta that begins at a column: a rotation, a lens, an effect.
template <class S>
int end_of_block(const Calibration<S>& theta, int column) {
  for (int c = 0; c < theta.n_cameras; ++c) {
    const int first = theta.camera_column(c),
              end = c + 1 < theta.n_cameras ? theta.camera_column(c + 1) : theta.imu_column();
    if (column < first || column >= end) continue;
    constexpr int kEnd[] = {3, 6, 8, 10};  // R_CI, p_CI, focal lengths, centre; then the lens
    for (const int e : kEnd) {
      if (column < first + e) return first + e;
    }
    return end;
  }
  const int imu = theta.imu_column();
  return column < imu + kImuColumns ? column + 3 - (column - imu) % 3 : column + 1;
}

}  // namespace SEGCAL_NS
