// Random numbers that are the same with every compiler and library: the standard fixes the bits of mt19937_64, but not
// the distributions, so the uniform and normal draws are made here.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <random>

namespace host::sim {

/// Each use of randomness has a stream of its own, so that changing one (more tracks, another noise) leaves the rest.
enum class Stream : std::uint64_t { device = 1, motion, scene, tracks, pixels, imu, biases, clock, stamps, exposures };

class Random {
 public:
  Random(std::uint64_t seed, Stream stream);

  /// Uniform in [0, 1).
  double uniform();
  /// Uniform in [low, high).
  double uniform(double low, double high) { return low + (high - low) * uniform(); }
  /// Uniform whole number in [low, high], both included.
  int integer(int low, int high);
  /// Standard normal.
  double normal();
  /// Three independent normals of standard deviation `sigma`.
  Eigen::Vector3d normal3(double sigma);

 private:
  std::mt19937_64 engine_;
  double spare_ = 0;
  bool has_spare_ = false;
};

}  // namespace host::sim
