// Random numbers that are the same with every standard library: the distributions are written here.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <random>

namespace test {

class Random {
 public:
  explicit Random(std::uint32_t seed) : engine_(seed) {}

  /// Uniform in [low, high).
  double uniform(double low, double high) { return low + (high - low) * (engine_() / 4294967296.0); }
  int index(int count) { return static_cast<int>(uniform(0, count)); }
  /// Normal with zero mean (Box and Muller).
  double normal(double sigma = 1) {
    const double u = uniform(0, 1), v = uniform(0, 1);
    return sigma * std::sqrt(-2 * std::log(1 - u)) * std::cos(6.283185307179586 * v);
  }
  Eigen::Vector3d vector(double sigma = 1) {
    const double x = normal(sigma), y = normal(sigma), z = normal(sigma);
    return {x, y, z};
  }
  /// A direction, all equally likely.
  Eigen::Vector3d direction() { return vector().normalized(); }
  Eigen::MatrixXd matrix(int rows, int columns) {
    Eigen::MatrixXd m(rows, columns);
    for (int i = 0; i < rows; ++i) {
      for (int j = 0; j < columns; ++j) m(i, j) = normal();
    }
    return m;
  }

 private:
  std::mt19937 engine_;
};

}  // namespace test
