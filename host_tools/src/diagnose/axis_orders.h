// The 48 orders and signs in which three axes can be wired.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace host {

struct AxisOrder {
  Eigen::Matrix3d P;  ///< right axes = P logged axes
  std::string name;   ///< of the rows: "y x -z" means right x is logged y
};

/// The identity first.
const std::vector<AxisOrder>& axis_orders();

}  // namespace host
