// White noise on a random walk, whitened.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <utility>

namespace host {

/// The Cholesky factor of a track's covariance, white noise on a random walk, in time that grows with its length: that
/// factor is the Kalman filter of the local level model (Durbin and Koopman, Time Series Analysis by State Space
/// Methods, 2nd ed., sections 2.2 to 2.4).
class Whitening {
 public:
  /// px^2, of the walk's steps and of the points.
  Whitening(Eigen::VectorXd step, const Eigen::VectorXd& white)
      : step_(std::move(step)), S_(step_.size()), gain_(step_.size()), kept_(step_.size()) {
    double P = 0;
    for (Eigen::Index i = 0; i < S_.size(); ++i) {
      P += step_(i);
      S_(i) = P + white(i);
      gain_(i) = P / S_(i);
      P *= white(i) / S_(i);
      kept_(i) = P;
    }
  }

  double log_determinant() const { return S_.array().log().sum(); }

  /// Each column times the inverse factor. Where the number of columns is known to the compiler, no row is allocated.
  template <class Columns>
  typename Columns::PlainObject operator()(const Eigen::MatrixBase<Columns>& columns) const {
    typename Columns::PlainObject out(columns.rows(), columns.cols());
    Row<Columns> walk = Row<Columns>::Zero(columns.cols());
    for (Eigen::Index i = 0; i < S_.size(); ++i) {
      out.row(i) = columns.row(i) - walk;
      walk += gain_(i) * out.row(i);
      out.row(i) /= std::sqrt(S_(i));
    }
    return out;
  }

  /// The walk in each column, given all of its points.
  template <class Columns>
  typename Columns::PlainObject walk_in(const Eigen::MatrixBase<Columns>& columns) const {
    typename Columns::PlainObject out(columns.rows(), columns.cols());
    Row<Columns> walk = Row<Columns>::Zero(columns.cols());
    for (Eigen::Index i = 0; i < S_.size(); ++i) {
      walk += gain_(i) * (columns.row(i) - walk);
      out.row(i) = walk;
    }
    for (Eigen::Index i = S_.size() - 2; i >= 0; --i) {
      const double ahead = kept_(i) + step_(i + 1);
      if (ahead > 0) out.row(i) += kept_(i) / ahead * (out.row(i + 1) - out.row(i)).eval();
    }
    return out;
  }

 private:
  template <class Columns>
  using Row = Eigen::Matrix<double, 1, Columns::ColsAtCompileTime>;

  Eigen::VectorXd step_, S_, gain_, kept_;  ///< px^2: S_ of a point before it is seen, kept_ of the walk after it
};

}  // namespace host
