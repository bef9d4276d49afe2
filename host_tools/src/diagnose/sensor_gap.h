// The gap of each sensor: how far are camera, gyroscope and accelerometer above their own noise, without and with the
// effects, on segments that were used neither to choose the effects nor to fit them?
//
// The sensors are taken one after the other (CoreSensorRows): the camera's chi2 is that of the images alone; the
// gyroscope's is what it adds when it joins, so it is about rates that disagree with the turns in the images; the
// accelerometer's is about forces that disagree with the motion that both see. A lens opens the camera's gap; a clock
// offset is nothing that images see in themselves, and opens the other two.
//
// The folds are those of the whole gap (nested_gap.h), and the same is free: on a fold's own rows theta, and all
// states; effects c come from the other segments. At their best, (theta, c) = x, sensor s has
//     q_s(x) = |E_s (x, -1)|^2,   sum over s = the rows' chi2,
// so that the falls of the three add up to the fall of the whole.
//
// What noise leaves. With variances f_t^2 of sensor t over the weights', as measured apart from the fit, E q_s = sum_t
// D_st f_t^2 and dof_s = sum_t D_st (CoreSensorRows::shared): a sensor's floor is the ratio, since the gyroscope is
// held against what images tell with their noise. Dof add up to residuals minus unknowns. Theta, fitted to the fold as
// well, takes its share: with A_s = R^-T E_s'E_s R^-1 and R'R = sum_s E_s'E_s + P, P of theta's prior,
//     D_st <- D_st - 2 tr A_s D_st / dof_s + sum_u tr A_s A_u D_ut / dof_u.
// (How tr A_s is shared out among noises t is not known without the rows, and is taken as D_st is:
// exact where all f are alike.) The prior has no place there: how far a device is from its data
// sheet is one draw for all folds. A prior that pulls would open the gap of a sensor that knows a
// direction no better than the prior by tr A_s R^-T P R^-1, up to a quarter in chi2 for each. It
// is taken ten times as wide as it is (kWidePrior): then a direction adds a 400th at most.
//
// The trained effects' own error, of covariance C, adds tr B'E_s'E_s B C to q_s with
// them, B = dx/dc along the best theta: it is taken off. Squares over floor and dof, less
// one, are the excess. It has the spread sqrt(2 / dof_s), and that of the measured f.
#pragma once

#include "diagnose/gap.h"
#include "diagnose/nested_gap.h"

namespace host::diagnosis {

/// Camera, gyroscope, accelerometer.
constexpr int kSensors = 3;

/// A recording's segments, sensor by sensor, over the columns of its problem.
struct SensorPieces {
  std::array<std::vector<Piece>, kSensors> of;  ///< rows that need be no triangles
  std::vector<Eigen::Matrix3d> shared;          ///< D of each segment
};

struct SensorGap {
  double dof = 0;
  double floor = 1;              ///< chi2/dof that noise leaves
  double before = 0, after = 0;  ///< excess of chi2/dof over the floor, in units of it; below zero by chance
  double sigma = 0;              ///< of both
  double fall = 0;               ///< of chi2 from before to after, as measured
};

/// `noise`: f^2 of each sensor.
std::array<SensorGap, kSensors> gap_by_sensor(const Selection& selection, const std::vector<Fold>& folds,
                                              const SensorPieces& pieces, const std::array<Floor, kSensors>& noise);

}  // namespace host::diagnosis
