// Eigenvalues of symmetric matrices of any size: a function of
// its own, since the compiler takes ten seconds for the method.
#pragma once

#include <Eigen/Core>

namespace host {

/// In ascending order.
Eigen::VectorXd eigenvalues_of(const Eigen::MatrixXd& symmetric);

}  // namespace host
