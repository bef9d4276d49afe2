#include "diagnose/compared_rates.h"

#include <cmath>

namespace host {
namespace {

void take_mean_off(std::vector<Eigen::Vector3d>& values) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const auto& v : values) sum += v;
  for (auto& v : values) v -= sum / static_cast<double>(values.size());
}

double rms_of(const std::vector<Eigen::Vector3d>& values) {
  double sum = 0;
  for (const auto& v : values) sum += v.squaredNorm();
  return values.empty() ? 0 : std::sqrt(sum / static_cast<double>(values.size()));
}

}  // namespace

double ComparedRates::image_rms() const { return rms_of(image_C); }
double ComparedRates::gyro_rms() const { return rms_of(gyro_I); }

double ComparedRates::correlation(const Eigen::Matrix3d& R) const {
  double sum = 0;
  for (std::size_t k = 0; k < size(); ++k) sum += image_C[k].dot(R * gyro_I[k]);
  const double norms = image_rms() * gyro_rms() * static_cast<double>(size());
  return norms > 0 ? sum / norms : 0;
}

ComparedRates rates_at(const std::vector<FramePair>& pairs, const std::vector<Eigen::Vector3d>& image,
                       const GyroPath& gyro, double offset) {
  ComparedRates out;
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const double t1 = pairs[k].t1 + offset, t2 = pairs[k].t2 + offset;
    if (!gyro.covers(t1, t2)) continue;
    out.image_C.push_back(image[k]);
    out.gyro_I.push_back(gyro.mean_rate(t1, t2));
  }
  take_mean_off(out.image_C);
  take_mean_off(out.gyro_I);
  return out;
}

}  // namespace host
