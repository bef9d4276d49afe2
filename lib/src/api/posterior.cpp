// The C API's answer as a Gaussian: mean and covariance of the
// printed parameters, for whoever fuses results of a device.
#include "api/handle.h"

namespace SEGCAL_NS {
namespace {

/// Row i of L, LL' the covariance of the printed values for the noise as stated. In units of the prior it is V
/// diag(1/(1+s^2)) V' (information/metrics.h); a component of a rotation vector is a sum of theta's columns.
void printed_row(const Device<Real>& device, int i, Real* row) {
  const Directions<Real>& a = device.report().directions;
  const PrintedValue<Real> value = printed_value(device.options().prior.mean, device.report().release.theta, i);
  for (int j = 0; j < a.n; ++j) {
    Real sum = Real(0);
    for (int k = 0; k < value.count; ++k) {
      sum += value.weight[k] * device.options().prior.sigma[value.first + k] * a.V[(value.first + k) * a.n + j];
    }
    row[j] = sum * a.relative_sigma(j);
  }
}

/// The part of printed value i's released sigma that is the fit's; the rest is what it may lag (calibrate_course.h), of
/// which no correlation is known. Where that was cut at the prior's sigma, what is left is no less than stated noise.
Real own_sigma(const Device<Real>& device, int i, Real stated) {
  const Real released = device.report().release.printed_sigma[i];
  const Real lag =
      printed_lag(device.report().course, printed_value(device.options().prior.mean, device.report().release.theta, i));
  if (!(lag > Real(0))) return released;
  const Real own = released * released - lag * lag, least = stated < released ? stated : released;
  return own > least * least ? square_root(own) : least;
}

}  // namespace
}  // namespace SEGCAL_NS

using namespace SEGCAL_NS;

extern "C" [[gnu::cold]] int segcal_get_posterior(const segcal_t* device, double* mean, double* covariance,
                                                  int32_t capacity) {
  if (!mean || !covariance) return SEGCAL_ERROR_NULL;
  const CDevice* d = open(device);
  if (!d || !d->device.has_report()) return SEGCAL_ERROR_STATE;
  const Release<Real>& release = d->device.report().release;
  const int n = d->device.report().directions.n;
  if (capacity < n * n) return SEGCAL_ERROR_SIZE;
  parameter_values(d->device.options().prior.mean, d->device.report().theta, mean);
  // Correlations times each value's own sigma, and the lags' squares on the diagonal, which is the released sigmas'
  // then: a matrix of correlations scaled from both sides stays positive definite.
  Real row[kMaxTheta], other[kMaxTheta];
  for (int i = 0; i < n; ++i) {
    printed_row(d->device, i, row);
    const Real length_i = square_root(factor_product(row, row, n));
    const double scale_i = static_cast<double>(own_sigma(d->device, i, length_i)) / static_cast<double>(length_i);
    for (int j = 0; j < i; ++j) {
      printed_row(d->device, j, other);
      const Real length_j = square_root(factor_product(other, other, n));
      const double scale_j = static_cast<double>(own_sigma(d->device, j, length_j)) / static_cast<double>(length_j);
      covariance[i * n + j] = covariance[j * n + i] =
          static_cast<double>(factor_product(row, other, n)) * scale_i * scale_j;
    }
    covariance[i * n + i] =
        static_cast<double>(release.printed_sigma[i]) * static_cast<double>(release.printed_sigma[i]);
  }
  return n;
}
