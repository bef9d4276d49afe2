#include "random.h"

#include <algorithm>
#include <cmath>

#include "angles.h"

namespace host::sim {
namespace {

/// Finaliser of splitmix64: spreads neighbouring seeds over all 64 bits.
std::uint64_t mixed(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15ull;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ull;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebull;
  return x ^ (x >> 31);
}

}  // namespace

Random::Random(std::uint64_t seed, Stream stream) : engine_(mixed(mixed(seed) + static_cast<std::uint64_t>(stream))) {}

double Random::uniform() { return static_cast<double>(engine_() >> 11) * 0x1.0p-53; }

int Random::integer(int low, int high) {
  const int n = high - low + 1;
  return low + std::min(n - 1, static_cast<int>(uniform() * n));
}

double Random::normal() {
  if (has_spare_) {
    has_spare_ = false;
    return spare_;
  }
  // Box and Muller; 1 - uniform() is in (0, 1], where the logarithm is finite.
  const double radius = std::sqrt(-2 * std::log(1 - uniform()));
  const double angle = 2 * pi * uniform();
  spare_ = radius * std::sin(angle);
  has_spare_ = true;
  return radius * std::cos(angle);
}

Eigen::Vector3d Random::normal3(double sigma) {
  const double x = normal(), y = normal(), z = normal();
  return sigma * Eigen::Vector3d(x, y, z);
}

}  // namespace host::sim
